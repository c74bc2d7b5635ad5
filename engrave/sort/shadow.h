#pragma once

// How many points of an order are fired through an earlier crack: an independent check
// that shares no code with the sorters.
//
// A point is violated when a crack made earlier lies in the cone above it
// (beam_cone.h; Trochimczuk 2008 ch. 1 and 6.7).

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_cone.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

/// Indices into the cloud. `crack` is the earliest of those in the cone of `point`.
struct ShadowPair {
  std::uint32_t point = 0;
  std::uint32_t crack = 0;
  bool operator==(const ShadowPair&) const = default;
};

struct ShadowReport {
  std::uint64_t violations = 0;  ///< violated points, each counted once
  /// The first violated points in the order of engraving, at most kMaxPairs.
  std::vector<ShadowPair> first;

  static constexpr std::size_t kMaxPairs = 8;
};

/// points_mm: glass frame, mm. order: indices into it, all or some. cone: in its ranges.
ShadowReport CheckShadow(const PointList& points_mm, const Order& order,
                         const BeamCone& cone);

/// The number alone, of points as they were made one after another. About half a
/// microsecond a point, several where many are violated.
std::uint64_t CountShadowViolations(const PointList& made_mm, const BeamCone& cone);

/// Of points that are made in the channels of their masks, one a point: a crack is in the
/// way only in its own channels. A point that is violated in several counts once.
std::uint64_t CountShadowViolations(const PointList& made_mm,
                                    std::span<const ChannelMask> masks,
                                    const BeamCone& cone);

/// The same number from the definition, every pair compared: for small clouds and as the
/// oracle of the other.
std::uint64_t CountShadowViolationsBruteForce(const PointList& made_mm,
                                              const BeamCone& cone);

}  // namespace intaglio::sort
