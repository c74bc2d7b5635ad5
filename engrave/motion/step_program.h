#pragma once

// The interface of a profile: the motion of one step from rest to rest, in whole ticks.
// Frame machine, mm. The planner of the steps is stop_and_go.h; the names are in
// profiles.h.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::motion {

/// Half a year at 1 Hz; a step beyond it means that a limit is mistaken, not slow.
inline constexpr std::uint64_t kMaxStepTicks = std::uint64_t{1} << 24;

/// Minimum duration of an arc: over shorter times the last bit of a coordinate shows as
/// acceleration (500 mm at 4 kHz: 1e-6 of 20 m/s^2 at this length).
inline constexpr std::uint64_t kShortestArcSubticks = kSubticksPerTick / 64;

/// Immutable, so for use by any number of threads.
class StepProgram {
 public:
  virtual ~StepProgram() = default;
  /// Adds the segments from rest at `from_mm` to rest at `to_mm`, another place, and
  /// returns their ticks, 1..kMaxStepTicks. The last one ends at `to_mm` and at rest
  /// exactly; none carries a point or a pulse.
  virtual std::uint64_t Append(const Vec3& from_mm, const Vec3& to_mm,
                               std::vector<Segment>& out) const = 0;
};

/// Adds a segment from knot to knot, split where longer than kMaxSegmentTicks. `knots`
/// are rising times in subticks from the start of the step, the first after 0; a repeated
/// time is skipped. `state_at(subticks)` gives the KnotState.
template <typename StateAt>
void AppendThroughKnots(std::span<const std::uint64_t> knots, StateAt&& state_at,
                        std::vector<Segment>& out) {
  constexpr std::uint64_t kLongest =
      static_cast<std::uint64_t>(kMaxSegmentTicks) * kSubticksPerTick;
  std::uint64_t at = 0;
  for (const std::uint64_t knot : knots) {
    while (at < knot) {
      const std::uint64_t duration = std::min(knot - at, kLongest);
      at += duration;
      const KnotState state = state_at(at);
      Segment segment;
      segment.end_position_mm = state.position_mm;
      segment.end_velocity_mm_s = state.velocity_mm_s;
      segment.duration_subticks = static_cast<std::uint32_t>(duration);
      out.push_back(segment);
    }
  }
}

/// The last segment of a step, without the rounding of its course.
inline void EndAtRest(const Vec3& at_mm, Segment& last) {
  last.end_position_mm = at_mm;
  last.end_velocity_mm_s.setZero();
}

}  // namespace intaglio::motion
