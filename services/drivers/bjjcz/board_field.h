#pragma once

// Places of the field of a BJJCZ board: 0..65535 on each axis, x to the right and y up,
// with the middle of the field at 32768. Corrections are in the board's own table.

#include <algorithm>
#include <cmath>

#include "engrave/core/geometry.h"

namespace intaglio::drivers {

inline constexpr double kMiddlePlace = 32768, kBoardPlaces = 65536;

struct BoardPlace {
  int x = 32768, y = 32768;
  bool operator==(const BoardPlace&) const = default;
};

class BoardField {
 public:
  explicit BoardField(double field_mm)
      : places_per_mm_(kBoardPlaces / std::max(1e-3, field_mm)) {}

  double places_per_mm() const { return places_per_mm_; }
  /// The nearest place, within the field.
  BoardPlace PlaceOf(const Vec2& at_mm) const {
    const auto place = [&](double mm) {
      return static_cast<int>(std::clamp(std::round(kMiddlePlace + mm * places_per_mm_),
                                         0.0, kBoardPlaces - 1));
    };
    return {place(at_mm.x()), place(at_mm.y())};
  }
  /// How far from the middle a place may lie on each axis, with one to spare for
  /// rounding.
  double border_mm() const { return (kMiddlePlace - 1) / places_per_mm_; }
  bool Contains(const Vec2& at_mm) const {
    return std::abs(at_mm.x()) <= border_mm() && std::abs(at_mm.y()) <= border_mm();
  }
  Vec2 ToMm(const BoardPlace& place) const {
    return Vec2(place.x - kMiddlePlace, place.y - kMiddlePlace) / places_per_mm_;
  }

 private:
  double places_per_mm_;
};

inline double PlacesBetween(const BoardPlace& from, const BoardPlace& to) {
  return std::hypot(to.x - from.x, to.y - from.y);
}

}  // namespace intaglio::drivers
