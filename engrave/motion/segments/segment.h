#pragma once

// The piece of motion that travels to the controller: position-velocity-time, frame
// machine, mm and mm/s. A segment is the cubic Hermite curve from the state at the
// knot before it to its own end, Trochimczuk 2008 ch. 6.2, eq. (16)-(20):
//   P(u) = h00 P0 + h01 P1 + h10 P0' + h11 P1',   u = t / duration in 0..1
//   h00 = 2u^3 - 3u^2 + 1, h01 = -2u^3 + 3u^2, h10 = u^3 - 2u^2 + u, h11 = u^3 - u^2
// with P0', P1' the velocities times the duration. Position and velocity are therefore
// continuous over knots by construction; acceleration may jump, inside it is linear.

#include <cstdint>

#include "engrave/core/geometry.h"

namespace intaglio::motion {

/// Durations are whole numbers of 1/65536 tick: their sums are exact, so a pulse a
/// million segments on still falls on its tick.
inline constexpr std::uint32_t kSubticksPerTick = 65536;

/// The longest duration of one segment: what a uint32 of subticks holds, whole ticks.
inline constexpr std::uint32_t kMaxSegmentTicks = 65535;

/// Position and velocity where two segments meet.
struct KnotState {
  Vec3 position_mm = Vec3::Zero();
  Vec3 velocity_mm_s = Vec3::Zero();
};

struct Segment {
  Vec3 end_position_mm = Vec3::Zero();
  Vec3 end_velocity_mm_s = Vec3::Zero();
  std::uint32_t duration_subticks = 0;  ///< > 0.
  bool pulse = false;                   ///< A point is to be made at the segment's end.
  bool program_end = false;             ///< At rest at its end, and nothing follows.
  /// Index in the planned list of the point made at this knot, or -1. A knot with a
  /// point lies on a whole tick from the program's start.
  std::int32_t point = -1;

  KnotState end() const { return {end_position_mm, end_velocity_mm_s}; }
};

/// Seconds of a duration at a tick rate of `rate_hz`.
inline double DurationSeconds(std::uint64_t subticks, double rate_hz) {
  return static_cast<double>(subticks) / (kSubticksPerTick * rate_hz);
}

// The curve `seconds` (0..duration_s) after the knot `from`, and its derivatives.
// `duration_s` is that of `to` in seconds, > 0.
Vec3 HermitePosition(const KnotState& from, const Segment& to, double seconds,
                     double duration_s);
Vec3 HermiteAcceleration(const KnotState& from, const Segment& to, double seconds,
                         double duration_s);
/// Constant over the segment, mm/s^3.
Vec3 HermiteJerk(const KnotState& from, const Segment& to, double duration_s);

/// The largest |speed| of each axis over the segment, mm/s; closed form.
Vec3 MaxSpeed(const KnotState& from, const Segment& to, double duration_s);
/// The largest |acceleration| of each axis over the segment, mm/s^2; closed form.
Vec3 MaxAcceleration(const KnotState& from, const Segment& to, double duration_s);

}  // namespace intaglio::motion
