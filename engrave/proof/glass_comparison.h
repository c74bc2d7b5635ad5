#pragma once

// The comparison of the glass with a job's plan: every crack is matched to a planned
// point. Frame glass, mm.
//
// A crack belongs to the planned point of its channel nearest to it, if that is nearer
// than the match radius: half the minimum spacing of the plan, so that no crack can
// belong to two points. A crack that belongs to no point is stray. A point is made when
// each of its channels holds one crack of it. The comparison does not use the journal or
// any other record of a service.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"

namespace intaglio::proof {

/// Cracks as the glass holds them. One value a crack: a proof keeps the positions longer
/// than the rest.
struct Cracks {
  PointList positions_mm;
  std::vector<std::uint64_t> ticks;   ///< when each was made
  std::vector<ChannelMask> channels;  ///< in whose glass, a single one each

  std::size_t size() const { return positions_mm.size(); }
};

/// The result for the points that have this channel, from the cracks of this channel
/// alone.
struct ChannelGlass {
  std::uint64_t planned_count = 0, made_count = 0, doubled_count = 0, empty_count = 0,
                stray_count = 0;
};

struct AxisErrors {
  double rms_um = 0;  ///< of the distance between crack and planned point
  double max_um = 0;
  Vec3 axis_rms_um = Vec3::Zero();
};

struct GlassComparison {
  std::uint64_t planned_count = 0;
  std::uint64_t made_count = 0;     ///< points with exactly one crack, in each channel
  std::uint64_t doubled_count = 0;  ///< points with more than one in a channel
  std::uint64_t empty_count = 0;    ///< the others: points without any in a channel
  std::uint64_t stray_count = 0;    ///< cracks that belong to no point
  AxisErrors errors;                ///< over the matched cracks
  std::array<ChannelGlass, kMaxChannels> channels;
  /// Cracks of each point, by its place in the plan: of its channels the fewest.
  std::vector<std::uint32_t> cracks_of_point;
  /// Points that have a crack, in the order of their first cracks' ticks.
  std::vector<std::uint32_t> made_order;
  std::uint64_t first_tick = 0;
  std::uint64_t last_tick = 0;
};

/// match_radius_mm > 0. `cracks` in any order; of equal ticks the given order counts. All
/// points are made in channel 1.
GlassComparison CompareGlass(const PointList& plan_mm, const Cracks& cracks,
                             double match_radius_mm);

/// The same of points that are made in the channels of `masks`, one a point, not 0.
GlassComparison CompareGlass(const PointList& plan_mm, std::span<const ChannelMask> masks,
                             const Cracks& cracks, double match_radius_mm);

/// Minimum distance between two of the points, mm; infinity for fewer than two. It does
/// not depend on the executor.
double MinSpacing(const PointList& points_mm, const Executor& executor = {});
/// The same of points in different channels: two count only if they share one.
double MinSpacing(const PointList& points_mm, std::span<const ChannelMask> masks,
                  const Executor& executor = {});

}  // namespace intaglio::proof
