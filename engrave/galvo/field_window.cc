#include "engrave/galvo/field_window.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"

namespace intaglio::galvo {
namespace {

constexpr int kLines = 513;
constexpr Span kNone{1, 0};
// Rounding of places that are at the border.
constexpr double kRoundingRatio = 1e-12;

/// How far from x = 0 towards `direction` (1 or -1) places of this line can be marked;
/// below 0: not at 0 either.
double ReachMm(double field_mm, const CorrectionTable& commands, double y_mm,
               double direction) {
  const double border_mm = field_mm / 2, step_mm = field_mm / (kLines - 1);
  const auto reaches = [&](double x_mm) {
    const Vec2 place_mm(direction * x_mm, y_mm);
    return (place_mm + commands.At(place_mm)).cwiseAbs().maxCoeff() <= border_mm;
  };
  if (!reaches(0)) return -1;
  double inside_mm = 0;
  for (int i = 1; i <= (kLines - 1) / 2; ++i) {
    double outside_mm = i * step_mm;
    if (reaches(outside_mm)) {
      inside_mm = outside_mm;
      continue;
    }
    while (outside_mm - inside_mm > 1e-9 * field_mm) {
      const double middle_mm = (inside_mm + outside_mm) / 2;
      (reaches(middle_mm) ? inside_mm : outside_mm) = middle_mm;
    }
    break;
  }
  return inside_mm;
}

}  // namespace

FieldWindow::FieldWindow(double field_mm) : field_mm_(field_mm), square_mm_(field_mm) {
  Require(field_mm > 0, "a field of {} mm", field_mm);
  lines_.assign(2, {-field_mm / 2, field_mm / 2});
}

FieldWindow::FieldWindow(double field_mm, const CorrectionTable& commands)
    : field_mm_(field_mm) {
  Require(field_mm > 0, "a field of {} mm", field_mm);
  for (int i = 0; i < kLines; ++i) {
    const double y_mm = field_mm * (static_cast<double>(i) / (kLines - 1) - 0.5);
    const double left_mm = ReachMm(field_mm, commands, y_mm, -1);
    lines_.push_back(left_mm < 0 ? kNone
                                 : Span{-left_mm, ReachMm(field_mm, commands, y_mm, 1)});
  }
  square_mm_ = SquareMm();
}

Span FieldWindow::AlongX(double min_y_mm, double max_y_mm) const {
  const double last = static_cast<double>(lines_.size()) - 1;
  const double rounding = kRoundingRatio * last;
  const double low = (min_y_mm / field_mm_ + 0.5) * last + rounding;
  const double high = (max_y_mm / field_mm_ + 0.5) * last - rounding;
  // What is no number is in no window.
  if (!(low >= 0 && high <= last && min_y_mm <= max_y_mm)) return kNone;
  Span span{-field_mm_ / 2, field_mm_ / 2};
  const auto begin = static_cast<std::size_t>(std::floor(low));
  const auto end = static_cast<std::size_t>(std::ceil(std::max(high, low)));
  for (std::size_t i = begin; i <= std::min(end, lines_.size() - 1); ++i) {
    span.from_mm = std::max(span.from_mm, lines_[i].from_mm);
    span.to_mm = std::min(span.to_mm, lines_[i].to_mm);
  }
  return span;
}

bool FieldWindow::Has(const Vec2& place_mm) const {
  const Span span = AlongX(place_mm.y(), place_mm.y());
  return !span.empty() && place_mm.x() >= span.from_mm && place_mm.x() <= span.to_mm;
}

Span FieldWindow::Displacements(std::span<const Vec2> places_mm, double margin_mm) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Span all{-kInfinity, kInfinity};
  if (is_square() && !places_mm.empty()) return InSquare(places_mm, margin_mm);
  for (const Vec2& place : places_mm) {
    const Span span = AlongX(place.y() - margin_mm, place.y() + margin_mm);
    if (span.empty()) return kNone;
    all.from_mm = std::max(all.from_mm, span.from_mm + margin_mm - place.x());
    all.to_mm = std::min(all.to_mm, span.to_mm - margin_mm - place.x());
  }
  return all;
}

// Places alike in all of their window: the outermost decide.
Span FieldWindow::InSquare(std::span<const Vec2> places_mm, double margin_mm) const {
  Vec2 min_mm = places_mm.front(), max_mm = min_mm;
  bool numbers = true;
  for (const Vec2& place : places_mm) {
    min_mm = min_mm.cwiseMin(place);
    max_mm = max_mm.cwiseMax(place);
    numbers = numbers && place.y() == place.y();
  }
  if (!numbers) return kNone;
  for (const double y_mm : {min_mm.y(), max_mm.y()})
    if (AlongX(y_mm - margin_mm, y_mm + margin_mm).empty()) return kNone;
  const Span& line = lines_.front();
  return {line.from_mm + margin_mm - min_mm.x(), line.to_mm - margin_mm - max_mm.x()};
}

double FieldWindow::SquareMm() const {
  double inside_mm = 0, outside_mm = field_mm_;
  const auto fits = [this](double width_mm) {
    const Span span = AlongX(-width_mm / 2, width_mm / 2);
    return !span.empty() && span.from_mm <= -width_mm / 2 && span.to_mm >= width_mm / 2;
  };
  if (fits(field_mm_)) return field_mm_;
  while (outside_mm - inside_mm > 1e-9 * field_mm_) {
    const double middle_mm = (inside_mm + outside_mm) / 2;
    (fits(middle_mm) ? inside_mm : outside_mm) = middle_mm;
  }
  return inside_mm;
}

}  // namespace intaglio::galvo
