#pragma once

// A scan head as ten numbers, from commands in mm to places in the measured frame. The
// control turns the mirrors by command / focal length; then
//   angles = command / f + zero, of y times the ratio of the axes
//   field = lens of the heights (f r1, 0, f r3, f r4) behind the mirrors (head.h)
//   place = turned field + offset + shear (0, field x)
// A lens that is not of this kind, or mirrors whose gain differs, leave residuals.

#include <array>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::galvo {

inline constexpr int kHeadModelNumbers = 10;

struct HeadModel {
  double focal_mm = 0;                 ///< known: mm of command per rad, optical
  double rotation_rad = 0;             ///< of the measured frame, counterclockwise
  Vec2 zero_rad = Vec2::Zero();        ///< optical angles at the command 0
  std::array<double, 3> lens_ratio{};  ///< r1, r3, r4
  Vec2 offset_mm = Vec2::Zero();       ///< of the measured frame
  double shear_ratio = 0;              ///< y by field x
  double axes_ratio = 1;               ///< gain of the mirror of y by that of x

  /// An ideal head: the place is the command but for the two mirrors' own distortion.
  static HeadModel Ideal(double focal_mm);
  /// In the order of kHeadModelNames.
  static HeadModel FromNumbers(double focal_mm,
                               const std::array<double, kHeadModelNumbers>& numbers);
  std::array<double, kHeadModelNumbers> Numbers() const;

  Vec2 Arrive(const Vec2& command_mm) const;
};

/// Names of the numbers with their units.
extern const std::array<const char*, kHeadModelNumbers> kHeadModelNames;

}  // namespace intaglio::galvo
