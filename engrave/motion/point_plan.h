#pragma once

// The motion through points with a pulse at each, whichever planner makes it, as a stream
// of segments. Frame machine, mm.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/planner.h"

namespace intaglio::motion {

/// Not for use by two threads at once.
class PointPlan {
 public:
  /// Receives the segments that are final, in their order, never none.
  using Sink = std::function<void(std::span<const Segment>)>;

  /// Starts at rest at `start_mm`, which is no point of its own.
  PointPlan(const PlanOptions& options, const Vec3& start_mm, Sink sink);

  /// Points are numbered from 0.
  void Append(const Vec3& point_mm);
  /// The stage rests at the last point; a next one begins there.
  void Rest();
  /// How far points were moved up to the last rest.
  const PointMoves& moves() const { return moves_; }

 private:
  void PassOn();

  PlanOptions options_;
  Sink sink_;
  Vec3 last_mm_;
  std::unique_ptr<Planner> planner_;  ///< none after a rest
  std::int32_t next_point_ = 0;
  std::vector<Segment> segments_;
  PointMoves moves_;
};

/// The whole way through `points_mm`, one or more, from rest at the first to rest at the
/// last.
std::vector<Segment> PlanPoints(const PlanOptions& options,
                                std::span<const Vec3> points_mm);

}  // namespace intaglio::motion
