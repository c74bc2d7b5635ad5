#pragma once

// The order of places that a tool visits, and its idle way. Frame: drawing, mm. The tool
// comes from `start` and does not return.
//
// The published program goes to the nearest place that is left, of several equally near
// to the one with the smaller way along Y: "along X first" (Siwiec 2016, ch. 8 and annex
// C). This is no optimum: on its grid of 4 x 4 holes the way is 15 to 17 steps, by the
// start. The improved order begins with it and is never longer.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"

namespace intaglio::contour {

/// Numbers of places, in the order of the visits.
using VisitOrder = std::vector<std::uint32_t>;

/// Distances that differ by no more are equal, mm: the published coordinates have four
/// decimals.
inline constexpr double kEqualDistance_mm = 1e-4;

/// The number of the place nearest to `at`, by the rule above; of places that are equal
/// in this too, the lowest. `places_mm` is not empty.
std::uint32_t NearestPlace(std::span<const Vec2> places_mm, const Vec2& at_mm);

/// By this rule until none is left. N^2 steps.
VisitOrder NearestOrder(std::span<const Vec2> places_mm, const Vec2& start_mm);

struct ImproveOptions {
  /// After the exchanges find nothing more (2-opt: a part reversed; Or-opt: up to three
  /// places moved elsewhere), so many times per place four edges near each other are
  /// exchanged at random and the result is kept when it is shorter.
  int tries_per_place = 8;
  std::uint32_t seed = 1;
  /// In shares of the work; false keeps the order that is found so far. May be empty.
  ProgressSink progress = {};
};

/// The order changed until no exchange shortens it.
void ImproveOrder(std::span<const Vec2> places_mm, const Vec2& start_mm,
                  VisitOrder& order, const ImproveOptions& options = {});

/// From the start through all places in this order.
double IdleWay_mm(std::span<const Vec2> places_mm, const Vec2& start_mm,
                  std::span<const std::uint32_t> order);

}  // namespace intaglio::contour
