#include "engrave/motion/point_shift.h"

#include <algorithm>

// With u_k = (x_k - x_{k-1}) / T_k the mean velocity of step k, the acceleration around
// point k is about (u_{k+1} - u_k) / t_k over t_k = (T_k + T_{k+1}) / 2, and
//   sum (u_{k+1} - u_k)^2 / t_k
// approximates the integral of its square. It is quadratic in each x_i, which enters
// three of the terms: sweeps over the points move each to its best place and from there
// back to within the tolerance.

namespace intaglio::motion {
namespace {

/// By trial, on scatter at 200 and 500 Hz.
constexpr int kSweeps = 10;
/// A step of several ticks is smoothed as if it took this much less, since it should.
constexpr double kHopedTicks = 0.5;

class Chain {
 public:
  Chain(const KnotState& start, std::span<const Vec3> targets_mm,
        std::span<const TimedStep> timed, double rate_hz, std::vector<Vec3>& shifted_mm)
      : start_(start), shifted_mm_(shifted_mm), per_s_(timed.size()) {
    shifted_mm.assign(targets_mm.begin(), targets_mm.end());
    for (std::size_t i = 0; i < timed.size(); ++i) {
      per_s_[i] = rate_hz / std::max(1.0, timed[i].ticks - kHopedTicks);
    }
  }

  /// The best place of point i with all others where they are; i is not the last.
  Vec3 Best(std::size_t i) const {
    Vec3 slope = Vec3::Zero();
    double curvature = 0;
    const auto add = [&](const Vec3& change, double by_x, double per_s) {
      slope += per_s * by_x * change;
      curvature += per_s * by_x * by_x;
    };
    const double p = per_s_[i], q = per_s_[i + 1];
    const Vec3 before = Mean(i), behind = Mean(i + 1);
    if (i == 0) {
      add(before - start_.velocity_mm_s, p, 2 * p);
    } else {
      add(before - Mean(i - 1), p, PerTime(i - 1, i));
    }
    add(behind - before, -p - q, PerTime(i, i + 1));
    if (i + 2 < per_s_.size()) add(Mean(i + 2) - behind, q, PerTime(i + 1, i + 2));
    return shifted_mm_[i] - slope / curvature;
  }

 private:
  Vec3 Mean(std::size_t step) const {
    const Vec3& from = step == 0 ? start_.position_mm : shifted_mm_[step - 1];
    return (shifted_mm_[step] - from) * per_s_[step];
  }
  double PerTime(std::size_t step, std::size_t next) const {
    return 2 * per_s_[step] * per_s_[next] / (per_s_[step] + per_s_[next]);
  }

  const KnotState& start_;
  std::vector<Vec3>& shifted_mm_;
  std::vector<double> per_s_;  ///< one by the time of each step
};

}  // namespace

void ShiftPoints(const KnotState& start, std::span<const Vec3> targets_mm,
                 std::span<const TimedStep> timed, double rate_hz, double tolerance_mm,
                 const Box3& travel_mm, std::vector<Vec3>& shifted_mm) {
  const Chain chain(start, targets_mm, timed, rate_hz, shifted_mm);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t i = 0; i + 1 < targets_mm.size(); ++i) {
      const Vec3& target = targets_mm[i];
      const Vec3 move = chain.Best(i) - target;
      const double length = move.norm();
      const Vec3 at = length > tolerance_mm ? Vec3(target + tolerance_mm / length * move)
                                            : Vec3(target + move);
      // A target beyond the travel stays on its side of it.
      shifted_mm[i] = at.cwiseMax(travel_mm.min_mm.cwiseMin(target))
                          .cwiseMin(travel_mm.max_mm.cwiseMax(target));
    }
  }
}

}  // namespace intaglio::motion
