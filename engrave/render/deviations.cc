#include "engrave/render/deviations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/render/text.h"

namespace intaglio::render {
namespace {

constexpr int kWidth = 1200, kPicture = 900, kMargin = 50;
constexpr double kArrowShare = 1.0 / 30;
constexpr double kLine = 24;

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

Canvas DrawDeviations(const std::vector<Deviation>& deviations,
                      const DeviationsCaption& caption) {
  const auto lines = static_cast<int>(caption.figures.size());
  Canvas canvas(kWidth, kPicture + 2 * kMargin + static_cast<int>(kLine) * (lines + 2));
  FillRect(canvas, {0, 0, canvas.width(), canvas.height()}, {Srgb(0x10141a)});
  const Extent extent = ExtentOf(deviations);
  const double scale = (kPicture - 2 * kMargin) / extent.size_mm.maxCoeff();
  const double by = MagnificationOf(deviations);
  const auto at_px = [&](const Vec2& mm) {
    const Vec2 from_low = scale * (mm - extent.min_mm);
    return Vec2(kMargin + from_low.x(), kMargin + kPicture - kMargin - from_low.y());
  };
  const TextStyle plain{10, Srgb(0xd8dee8)};
  DrawText(canvas, {kMargin, 30}, caption.title, {14, Srgb(0xffffff)});
  for (const Deviation& d : deviations) {
    const Vec2 from_px = at_px(d.place_mm), to_px = at_px(d.place_mm + by * d.by_mm);
    DrawLine(canvas, from_px, to_px, 1.5, {Srgb(0xffb454)});
    DrawDisc(canvas, from_px, 1.5, {Srgb(0x6aa7e0)});
    DrawDisc(canvas, to_px, 2.5, {Srgb(0xffb454)});
  }
  double y_px = kPicture + kMargin + kLine;
  DrawText(canvas, {kMargin, y_px},
           fmt::format("blue: places; orange: marks, deviations {:g} times as long", by),
           plain);
  for (const std::string& figure : caption.figures) {
    DrawText(canvas, {kMargin, y_px += kLine}, figure, plain);
  }
  return canvas;
}

}  // namespace intaglio::render
