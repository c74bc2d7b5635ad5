#pragma once

// Order and time for a controller that jumps to a point, rests, fires there and goes on,
// and moves z only between its lists: the boards of scan heads that most machines have.
// A point takes d / jump_mm_s + jump_delay_s + dwell_s, whatever came before, and a
// change of the height costs as much as hundreds of points. So: one layer at a time, the
// deepest first, all points of a height of the axis z in one layer; within a layer the
// shortest way of the mirrors: nearest neighbours, then 2-opt and Or-opt among near
// points.
//
// Where points have energies of their own, each change takes a list of its own, some
// milliseconds, against 0.1 ms of a jump. So a layer begins with the nearest point next,
// and with an energy after the other, rising and falling; each is made shorter with what
// the changes cost, and the way of least time is taken.
//
// Layers are heights of the axis, which are bent surfaces in the glass under a lens that
// is not telecentric. A lower layer never shades a higher one as long as such a surface
// is flatter than the cone is steep: dz/dr <= 0.2 at 15 degrees and 60 mm depth, where a
// cone that leans 13 degrees has a tangent of 0.25, so their product is far below 1.
// Within a layer the cone of each point decides (cone_order.h), which leans as its beam
// does (beam_lean.h); where it leans, also between layers, should a lens bend them more.

#include <cstdint>
#include <span>

#include "engrave/core/geometry.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

/// What a controller that jumps and dwells takes, and its axis z from rest to rest.
struct JumpTimes {
  double jump_mm_s = 2000;  ///< > 0
  double jump_delay_s = 0;  ///< >= 0
  double dwell_s = 0.0005;  ///< >= 0, of a point
  double z_mm_s = 10;       ///< > 0
  double z_mm_s2 = 1000;    ///< > 0
  double z_settle_s = 0;    ///< >= 0, behind each move of z
  /// Of a list of the controller; 0: no limit.
  std::uint32_t max_list_points = 0;
  /// Behind so many points the controller rests for pause_s; 0: never.
  std::uint32_t pause_after_points = 0;
  double pause_s = 0;  ///< >= 0
};

struct JumpTime {
  double jump_s = 0, delay_s = 0, dwell_s = 0, z_s = 0, pause_s = 0;
  std::uint64_t z_move_count = 0;
  std::uint64_t energy_change_count = 0;  ///< from a point to the next of its layer
  std::uint64_t list_count = 0;           ///< of one height and one energy each
  double total_s() const { return jump_s + delay_s + dwell_s + z_s + pause_s; }
};

/// The time of points in the order in which they are made, by their axes: x, y of the
/// mirrors and height z, mm. While z moves the mirrors do not. The ways to the first are
/// not counted. `energies`: the number of each point's energy; empty: all have the same.
JumpTime TimeOfJumps(std::span<const Vec3> axes_mm, const JumpTimes& times,
                     std::span<const std::uint32_t> energies = {});

Status CheckJumpLayersOptions(const OrderOptions& options);

/// Starts at the lowest point of the lowest layer. Time: n log n, and memory of 100 bytes
/// a point. Options and points must have been checked by MakeOrder.
Result<Order> OrderByJumpLayers(const PointList& points_mm, const OrderOptions& options,
                                const ProgressSink& progress);

}  // namespace intaglio::sort
