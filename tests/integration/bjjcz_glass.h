#pragma once

// Where a board's places lie in the glass, by a ray trace of the tests' own, at the
// supplied profile bjjcz-glass and a block of 50 x 50 x 30 mm.

#include <cmath>

#include "engrave/core/geometry.h"

namespace intaglio::testing {

// The supplied profile has these; N-BK7 at 355 nm (Schott's Sellmeier coefficients).
inline constexpr double kBoardFieldMm = 110, kBoardPupilMm = 224, kBoardIndex = 1.538155;
inline constexpr double kHalfBlockMm = 25, kBlockHeightMm = 30;

/// Where a beam that is aimed at a place of the field, so far below the face, is in
/// focus: in the middle between its sagittal and its tangential focus, which neighbouring
/// rays have by Snell's law.
inline Vec3 FocusInGlass(const Vec2& field_mm, double below_mm) {
  const auto in_glass = [](double angle) {
    return std::asin(std::sin(angle) / kBoardIndex);
  };
  const double across_mm = field_mm.norm(), angle = std::atan(across_mm / kBoardPupilMm);
  constexpr double kNear = 1e-4;
  const double tangential_mm =
      below_mm * (std::tan(angle + kNear) - std::tan(angle - kNear)) /
      (std::tan(in_glass(angle + kNear)) - std::tan(in_glass(angle - kNear)));
  const double sagittal_mm = angle > 1e-6
                                 ? below_mm * std::tan(angle) / std::tan(in_glass(angle))
                                 : tangential_mm;
  const double depth_mm = (sagittal_mm + tangential_mm) / 2;
  const double aside_mm =
      depth_mm * std::tan(in_glass(angle)) - below_mm * std::tan(angle);
  const Vec2 at_mm =
      across_mm > 0 ? Vec2(field_mm * (1 + aside_mm / across_mm)) : field_mm;
  return {at_mm.x() + kHalfBlockMm, at_mm.y() + kHalfBlockMm, kBlockHeightMm - depth_mm};
}

}  // namespace intaglio::testing
