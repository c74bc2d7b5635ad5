#include "engrave/machine/arm_length.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/machine/axes_from_glass.h"
#include "engrave/machine/polar.h"

// By polar.cc a place at the distance r from the table's axis has the arm at theta1 from
// the line to that axis, r^2 = r1^2 + d^2 - 2 r1 d cos(theta1), which grows with r. With
// theta1 between a and b, by the margin at the line and by the arm's travel, the nearest
// place n of the box and the farthest f give
//   n^2 >= r1^2 + d^2 - 2 r1 d cos a,  r1 within d cos a -+ sqrt(n^2 - d^2 sin^2 a),
//   f^2 <= r1^2 + d^2 - 2 r1 d cos b,  r1 not within d cos b -+ sqrt(f^2 - d^2 sin^2 b).
// The table's angle of a place grows with r1 on the left and falls on the right, so its
// travel cuts a range from both ends; where, is searched by steps and then by halving.

namespace intaglio::machine {
namespace {

using std::numbers::pi;

constexpr int kSteps = 128;
constexpr int kHalvings = 40;

struct Angles {
  double min_rad, max_rad;
};

/// theta1 that the margin and the travel of the arm leave.
Angles AnglesOf(const PolarOptions& options, const Box3& travel) {
  const bool left = options.side == ArmSide::kLeft;
  double from = left ? 2 * pi - travel.max_mm.x() : travel.min_mm.x();
  double to = left ? 2 * pi - travel.min_mm.x() : travel.max_mm.x();
  // The turn of the arm that has the middle of its travel.
  const double turns = 2 * pi * std::round((pi / 2 - 0.5 * (from + to)) / (2 * pi));
  if (std::isfinite(turns)) {
    from += turns;
    to += turns;
  }
  return {std::max(from, options.singular_margin_rad),
          std::min(to, pi - options.singular_margin_rad)};
}

/// The lengths that margin and travel of the arm leave, growing.
std::vector<ArmLengths> LengthsOfArm(const PolarOptions& options, const Box3& places_mm,
                                     const Box3& travel) {
  const double d_mm = options.axis_distance_mm;
  const auto [a, b] = AnglesOf(options, travel);
  if (!(a < b)) return {};
  const Vec2 low = places_mm.min_mm.head<2>(), high = places_mm.max_mm.head<2>();
  const double nearest_mm = low.cwiseMax(-high).cwiseMax(0).norm();
  const double farthest_mm = low.cwiseAbs().cwiseMax(high.cwiseAbs()).norm();
  const double aside_mm = d_mm * std::sin(a);
  if (nearest_mm < aside_mm) return {};
  const double half_mm = std::sqrt(nearest_mm * nearest_mm - aside_mm * aside_mm);
  const ArmLengths near{std::max(d_mm * std::cos(a) - half_mm, 0.0),
                        d_mm * std::cos(a) + half_mm};
  const double square = farthest_mm * farthest_mm - std::pow(d_mm * std::sin(b), 2);
  if (square <= 0) return {near};
  const double middle_mm = d_mm * std::cos(b), far_mm = std::sqrt(square);
  std::vector<ArmLengths> found;
  for (const ArmLengths& range :
       {ArmLengths{near.min_mm, std::min(near.max_mm, middle_mm - far_mm)},
        ArmLengths{std::max(near.min_mm, middle_mm + far_mm), near.max_mm}}) {
    if (range.min_mm <= range.max_mm && range.max_mm > 0) found.push_back(range);
  }
  return found;
}

bool TableTurnsSoFar(PolarOptions options, double arm_length_mm, const Box3& places_mm,
                     const Box3& travel) {
  options.arm_length_mm = arm_length_mm;
  const auto axes = AxesOver({{}, MakePolar(options)}, places_mm, travel);
  return axes && axes->min_mm.y() >= travel.min_mm.y() &&
         axes->max_mm.y() <= travel.max_mm.y();
}

/// The part of a range that the table's travel leaves.
std::optional<ArmLengths> CutByTable(const PolarOptions& options, const ArmLengths& range,
                                     const Box3& places_mm, const Box3& travel) {
  const auto turns = [&](double arm_length_mm) {
    return TableTurnsSoFar(options, arm_length_mm, places_mm, travel);
  };
  const auto at = [&](int step) {
    // At its ends rounding decides whether the margin is kept.
    const double share = std::clamp(static_cast<double>(step) / kSteps, 1e-9, 1 - 1e-9);
    return std::lerp(range.min_mm, range.max_mm, share);
  };
  const auto halve = [&](double in, double out) {
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (in + out);
      (turns(middle) ? in : out) = middle;
    }
    return in;
  };
  // A place is less than a turn from the first one, and that within half a turn of the
  // middle.
  if (travel.max_mm.y() - travel.min_mm.y() >= 4 * pi) return range;
  int first = 0;
  while (first <= kSteps && !turns(at(first))) ++first;
  if (first > kSteps) return std::nullopt;
  int last = first;
  while (last < kSteps && turns(at(last + 1))) ++last;
  return ArmLengths{first == 0 ? range.min_mm : halve(at(first), at(first - 1)),
                    last == kSteps ? range.max_mm : halve(at(last), at(last + 1))};
}

}  // namespace

std::optional<ArmLengths> ArmLengthsOver(const PolarOptions& options,
                                         const Box3& places_mm, const Box3& travel) {
  Require(!places_mm.empty(), "arm lengths over an empty box");
  for (const ArmLengths& range : LengthsOfArm(options, places_mm, travel)) {
    if (const auto cut = CutByTable(options, range, places_mm, travel)) return cut;
  }
  return std::nullopt;
}

}  // namespace intaglio::machine
