#include "engrave/render/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"
#include "engrave/render/text.h"

namespace intaglio::render {
namespace {

constexpr std::array<std::uint32_t, 6> kColors = {0x8E99A8, 0x4FC3F7, 0xFFB74D,
                                                  0x81C784, 0xE57373, 0xBA68C8};
constexpr std::uint32_t kGround = 0x14181F, kFrame = 0x3A424E, kText = 0xD5DAE2;
constexpr int kLeftPx = 110, kRightPx = 30, kTopPx = 60, kBottomPx = 70;
constexpr double kCapPx = 12, kLinePx = 2;

struct Scale {
  std::vector<double> marks;
  double from_px = 0, to_px = 1;
  double At(double value) const {
    const double ratio = (value - marks.front()) / (marks.back() - marks.front());
    return from_px + ratio * (to_px - from_px);
  }
};

Scale ScaleOf(const std::vector<Curve>& curves, int axis, double from_px, double to_px,
              int count) {
  double min = std::numeric_limits<double>::infinity(), max = -min;
  for (const Curve& curve : curves) {
    for (const Vec2& p : curve.points) {
      if (!p.allFinite()) continue;
      min = std::min(min, p[axis]), max = std::max(max, p[axis]);
    }
  }
  if (!(min <= max)) min = 0, max = 1;
  return {RoundNumbers(min, max, count), from_px, to_px};
}

void DrawFrame(Canvas& canvas, const Scale& x, const Scale& y,
               const ChartOptions& options) {
  const Paint line{Srgb(kFrame), 1.0F};
  TextStyle style{kCapPx, Srgb(kText)};
  style.align = Align::kCenter;
  for (const double mark : x.marks) {
    DrawLine(canvas, {x.At(mark), y.from_px}, {x.At(mark), y.to_px}, 1, line);
    DrawText(canvas, {x.At(mark), y.from_px + 24}, fmt::format("{:.6g}", mark), style);
  }
  DrawText(canvas, {0.5 * (x.from_px + x.to_px), y.from_px + 54}, options.x_label, style);
  style.align = Align::kRight;
  for (const double mark : y.marks) {
    DrawLine(canvas, {x.from_px, y.At(mark)}, {x.to_px, y.At(mark)}, 1, line);
    DrawText(canvas, {x.from_px - 12, y.At(mark) + 5}, fmt::format("{:.6g}", mark),
             style);
  }
  style.align = Align::kLeft;
  DrawText(canvas, {12, kTopPx - 14.0}, options.y_label, style);
  style.cap_height_px = 15;
  DrawText(canvas, {static_cast<double>(kLeftPx), 28}, options.title, style);
}

}  // namespace

std::vector<double> RoundNumbers(double min, double max, int count) {
  Require(count >= 2 && min <= max, "{} marks of {}..{}", count, min, max);
  const double size = std::max({std::abs(min), std::abs(max), 1e-300});
  if (max - min < 1e-9 * size) min -= 0.5 * size, max += 0.5 * size;
  const double min_step = (max - min) / std::max(1, count - 2);
  double step = std::pow(10, std::floor(std::log10(min_step)));
  for (const double factor : {2.0, 2.5, 2.0}) {
    if (step >= min_step) break;
    step *= factor;
  }
  const double first = std::floor(min / step), last = std::ceil(max / step);
  std::vector<double> marks;
  for (double k = first; k <= std::max(last, first + 1); ++k) marks.push_back(k * step);
  return marks;
}

Canvas DrawChart(const std::vector<Curve>& curves, const ChartOptions& options) {
  Require(options.width_px >= 200 && options.width_px <= 8000 &&
              options.height_px >= 200 && options.height_px <= 8000,
          "a chart of {} x {} pixels", options.width_px, options.height_px);
  Canvas canvas(options.width_px, options.height_px);
  FillRect(canvas, {0, 0, options.width_px, options.height_px}, {Srgb(kGround), 1.0F});
  const Scale x =
      ScaleOf(curves, 0, kLeftPx, options.width_px - static_cast<double>(kRightPx), 12);
  const Scale y =
      ScaleOf(curves, 1, options.height_px - static_cast<double>(kBottomPx), kTopPx, 10);
  DrawFrame(canvas, x, y, options);
  double legend_px = options.width_px - 20.0;
  for (std::size_t i = curves.size(); i-- > 0;) {
    const Color color = Srgb(kColors[i % kColors.size()]);
    TextStyle style{kCapPx, color};
    style.align = Align::kRight;
    DrawText(canvas, {legend_px, 28}, curves[i].name, style);
    legend_px -= TextWidth(curves[i].name, kCapPx) + 24;
  }
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Paint paint{Srgb(kColors[i % kColors.size()]), 1.0F};
    const auto& points = curves[i].points;
    for (std::size_t k = 1; k < points.size(); ++k) {
      if (!points[k - 1].allFinite() || !points[k].allFinite()) continue;
      DrawLine(canvas, {x.At(points[k - 1].x()), y.At(points[k - 1].y())},
               {x.At(points[k].x()), y.At(points[k].y())}, kLinePx, paint);
    }
  }
  return canvas;
}

}  // namespace intaglio::render
