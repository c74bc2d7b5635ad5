#pragma once

// Independent check of a plan: it uses only the segments and the limits, not how they
// were made, and shares no code with the planners. Frame machine, mm.
//
// Each segment is taken as a Bezier curve; its speed and acceleration are both evaluated
// in closed form at their extremes and sampled densely by de Casteljau's rule, so an
// error in one is detected by the other.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::motion {

struct VerifyOptions {
  /// Share by which a limit may be passed. 1e-6: planners round times to a relative 1e-9,
  /// and no drive's limit is known to better than a per cent.
  double limit_slack_ratio = 1e-6;
  /// How far from its place a point's knot may lie. 1e-9 mm: rounding of doubles.
  double position_tolerance_mm = 1e-9;
  /// Samples inside each segment.
  int samples = 8;
  /// Whether every planned point has to be reached (false for a part of a plan).
  bool all_points = true;
};

struct MotionReport {
  std::uint64_t ticks = 0;   ///< Duration in ticks; a part of a tick counts as one.
  std::uint64_t points = 0;  ///< Points reached at their whole tick.
  Vec3 max_speed_mm_s = Vec3::Zero();
  Vec3 max_acceleration_mm_s2 = Vec3::Zero();
  /// Inside segments; where the acceleration jumps at a knot it is unbounded, which
  /// counts as a violation on an axis whose jerk is limited.
  Vec3 max_jerk_mm_s3 = Vec3::Zero();
  double peak_speed_mm_s = 0.0;          ///< Of the vector's length.
  double peak_acceleration_mm_s2 = 0.0;  ///< Of the vector's length.
  double rms_acceleration_mm_s2 = 0.0;   ///< Over time, of the vector's length.
  /// Total variation of the acceleration vector over time, jumps at knots and at the
  /// start and end included: what shakes the machine.
  double mean_jerk_mm_s3 = 0.0;
  double path_mm = 0.0;            ///< Length of the way, from the samples.
  Box3 extent_mm;                  ///< The maxima that the motion reaches.
  double max_point_move_mm = 0.0;  ///< Largest distance of a knot from its point.
  std::uint64_t violation_count = 0;
  /// The first 20 violations, a sentence each.
  std::vector<std::string> violations;

  bool ok() const { return violation_count == 0; }
};

/// Checks that the motion starts and ends at rest, keeps to all `limits` that are set
/// (where jerk is limited the acceleration is 0 at start and end), and passes every point
/// of `planned_mm` once, at a whole tick, in its place; that the program ends only at
/// rest, with the last segment. Takes the segments as they come and keeps none, so a way
/// of any length is checked while it is planned. Not for use by two threads at once.
class MotionVerifier {
 public:
  /// `planned_mm` must outlive the verifier. Throws PreconditionError unless rate_hz > 0
  /// and options.samples >= 0.
  MotionVerifier(const KnotState& start, const PointList& planned_mm,
                 const Limits& limits, double rate_hz, const VerifyOptions& options = {});

  void Append(const Segment& segment);
  /// The report of all that was appended; once, at the end.
  MotionReport Finish();

 private:
  void Violate(std::string sentence);
  void CheckCurve(const Segment& to);
  void CheckAxes(const Segment& to, double d, const Vec3& speed,
                 const Vec3& acceleration);
  void CheckLengths(const Segment& to, double d, double speed, double acceleration);
  void CheckJerk(const Segment& to, double d, const Vec3& a0, const Vec3& a1);
  void CheckJump(int axis, double to_mm_s2, double bits);
  void CheckTravel(const Box3& extent_mm);
  void CheckPoint(const Segment& to);

  const PointList& planned_mm_;
  Limits limits_;
  double rate_hz_;
  VerifyOptions options_;
  KnotState from_;           ///< Where the segments so far end.
  std::size_t segment_ = 0;  ///< Number of the segment that is being checked.
  bool program_ended_ = false;
  std::vector<bool> seen_;
  MotionReport report_;
  std::uint64_t subticks_ = 0;
  Vec3 acceleration_ = Vec3::Zero();  ///< At the end of the segment before.
  double acceleration_bits_ = 0.0;    ///< What rounding may make of it, mm/s^2.
  double square_ = 0.0;               ///< Integral of |a|^2, mm^2/s^3.
  double variation_ = 0.0;            ///< Of the acceleration, mm/s^2.
};

}  // namespace intaglio::motion
