#include "engrave/render/deviations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/render/text.h"

namespace intaglio::render {
namespace {

constexpr int kPanel = 900, kMargin = 60, kTop = 70, kLegend = 40;
constexpr int kMinWidth = 1200;  // lines of figures are long
constexpr double kArrowShare = 1.0 / 30;
constexpr double kLine = 24, kColumn = 150;
constexpr double kMinBarPx = 50;  // of the bar that shows the scale

struct Extent {
  Vec2 min_mm = Vec2::Zero(), size_mm = Vec2::Ones();
};

Extent ExtentOf(const std::vector<Deviation>& deviations) {
  if (deviations.empty()) return {};
  Vec2 low = deviations[0].place_mm, high = low;
  for (const Deviation& d : deviations) {
    low = low.cwiseMin(d.place_mm);
    high = high.cwiseMax(d.place_mm);
  }
  return {low, (high - low).cwiseMax(1e-6)};
}

/// 1, 2 or 5 times a power of ten, at least this.
double RoundUp(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= value * (1 - 1e-9)) return digit * power;
  return 10 * power;
}

const Deviation* LongestOf(const std::vector<Deviation>& deviations) {
  const auto longest = std::max_element(deviations.begin(), deviations.end(),
                                        [](const Deviation& a, const Deviation& b) {
                                          return a.by_mm.norm() < b.by_mm.norm();
                                        });
  return longest == deviations.end() ? nullptr : &*longest;
}

class PanelDrawing {
 public:
  PanelDrawing(Canvas& canvas, const DeviationPanel& panel, int left_px)
      : canvas_(canvas),
        panel_(panel),
        left_px_(left_px),
        extent_(ExtentOf(panel.deviations)),
        px_per_mm_((kPanel - 2 * kMargin) / extent_.size_mm.maxCoeff()),
        by_(MagnificationOf(panel.deviations)) {}

  void Draw() {
    DrawText(canvas_, {left_px_ + kMargin, 32.0}, panel_.title, {14, Srgb(0xffffff)});
    DrawCorners();
    const Deviation* longest = LongestOf(panel_.deviations);
    for (const Deviation& d : panel_.deviations) DrawArrow(d, &d == longest);
    DrawLegend(longest);
  }

 private:
  Vec2 AtPx(const Vec2& mm) const {
    const Vec2 from_low = px_per_mm_ * (mm - extent_.min_mm);
    return {left_px_ + kMargin + from_low.x(), kTop + kPanel - kMargin - from_low.y()};
  }
  /// Coordinates of the lowest and the highest place.
  void DrawCorners() {
    const Vec2 high_mm = extent_.min_mm + extent_.size_mm;
    for (const Vec2& mm : {extent_.min_mm, high_mm}) {
      const Vec2 at_px = AtPx(mm);
      const double down_px = mm == high_mm ? -22 : 32;
      DrawText(canvas_, {at_px.x() - 24, at_px.y() + down_px},
               fmt::format("{:.4g}, {:.4g} mm", mm.x(), mm.y()), {8, Srgb(0x8a94a3)});
    }
  }
  void DrawArrow(const Deviation& d, bool longest) {
    const Vec2 from_px = AtPx(d.place_mm), to_px = AtPx(d.place_mm + by_ * d.by_mm);
    const Color color = Srgb(longest ? 0xff5a5a : 0xffb454);
    DrawLine(canvas_, from_px, to_px, longest ? 2.5 : 1.5, {color});
    DrawDisc(canvas_, from_px, 1.5, {Srgb(0x6aa7e0)});
    DrawDisc(canvas_, to_px, longest ? 3.5 : 2.5, {color});
  }
  void DrawLegend(const Deviation* longest) {
    const double y_px = kTop + kPanel + kLegend / 2.0;
    const double um_per_px = 1000 / (by_ * px_per_mm_);
    const double bar_um = RoundUp(kMinBarPx * um_per_px);
    const double end_px = left_px_ + kMargin + bar_um / um_per_px;
    DrawLine(canvas_, {left_px_ + kMargin, y_px - 5}, {end_px, y_px - 5}, 3,
             {Srgb(0xffb454)});
    std::string text = fmt::format("{:g} um; deviations {:g} times as long", bar_um, by_);
    if (longest != nullptr) {
      text += fmt::format("; red: the largest, {:.4g} um at {:.4g}, {:.4g} mm",
                          1000 * longest->by_mm.norm(), longest->place_mm.x(),
                          longest->place_mm.y());
    }
    DrawText(canvas_, {end_px + 15, y_px}, text, {10, Srgb(0xd8dee8)});
  }

  Canvas& canvas_;
  const DeviationPanel& panel_;
  double left_px_;
  Extent extent_;
  double px_per_mm_, by_;
};

/// "sigma         5 um": name and value in two columns.
void DrawFigure(Canvas& canvas, double y_px, const std::string& figure) {
  const TextStyle plain{10, Srgb(0xd8dee8)};
  const std::size_t name_end = figure.find("  ");
  DrawText(canvas, {kMargin, y_px}, figure.substr(0, name_end), plain);
  if (name_end == std::string::npos) return;
  const std::size_t value = figure.find_first_not_of(' ', name_end);
  if (value != std::string::npos)
    DrawText(canvas, {kMargin + kColumn, y_px}, figure.substr(value), plain);
}

}  // namespace

double MagnificationOf(const std::vector<Deviation>& deviations) {
  double square = 0;
  for (const Deviation& d : deviations) square += d.by_mm.squaredNorm();
  if (square == 0) return 1;
  const double rms_mm = std::sqrt(square / static_cast<double>(deviations.size()));
  const double wanted = kArrowShare * ExtentOf(deviations).size_mm.maxCoeff() / rms_mm;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  const double digit = wanted / power;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

Canvas DrawDeviations(const std::vector<DeviationPanel>& panels,
                      const std::vector<std::string>& figures) {
  const int width = std::max(kMinWidth, kPanel * static_cast<int>(panels.size()));
  const int lines = static_cast<int>(figures.size());
  Canvas canvas(width, kTop + kPanel + kLegend + static_cast<int>(kLine) * (lines + 2));
  FillRect(canvas, {0, 0, canvas.width(), canvas.height()}, {Srgb(0x10141a)});
  for (std::size_t i = 0; i < panels.size(); ++i)
    PanelDrawing(canvas, panels[i], kPanel * static_cast<int>(i)).Draw();
  double y_px = kTop + kPanel + kLegend + kLine;
  for (const std::string& figure : figures) {
    DrawFigure(canvas, y_px, figure);
    y_px += kLine;
  }
  return canvas;
}

}  // namespace intaglio::render
