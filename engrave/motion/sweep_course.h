#pragma once

// A slow axis that sweeps past points: where it is at given times, such that it passes
// each place within a tolerance and its velocity changes as little as it can.
//
// A crack is long along the beam, so the focus may be a part of its length above or below
// its point. The places p_i +- tolerance at the times of the points are a tube, and the
// course through the tube with the least integral of the squared acceleration needs the
// axis to be fast nowhere without need.

#include <span>
#include <vector>

namespace intaglio::motion {

/// The axis before its first place.
struct SweepStart {
  double position_mm = 0;
  double speed_mm_s = 0;
};

class SweepCourse {
 public:
  /// Writes a place for each of `targets_mm` to `places_mm`, none farther than
  /// `tolerance_mm` >= 0 from its target. `seconds`: of the step to each, > 0.
  /// `acceleration_mm_s2` > 0: of the axis; it decides over which time corners are
  /// rounded. `to_last`: the last place is its target.
  void Solve(const SweepStart& start, std::span<const double> targets_mm,
             std::span<const double> seconds, double tolerance_mm,
             double acceleration_mm_s2, bool to_last, std::vector<double>& places_mm);

 private:
  void TakeTautString(const SweepStart& start);
  void AddBending(const SweepStart& start, std::span<const double> seconds);
  void Factorize();
  void BackSubstitute(std::vector<double>& values) const;
  double StepTowardsTube();
  void Stiffen();

  // One value a place; the vectors are kept between calls for their memory.
  std::vector<double> times_s_, low_mm_, high_mm_;
  /// The quadratic form z' H z - 2 g' z: diagonals of H, and g.
  std::vector<double> diagonal_, beside_, beyond_, linear_;
  /// Its factors L D L'.
  std::vector<double> pivot_, left_, left_left_;
  std::vector<double> weight_, smooth_mm_, inside_mm_, dual_mm_;
};

}  // namespace intaglio::motion
