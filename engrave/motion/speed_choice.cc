#include "engrave/motion/speed_choice.h"

#include <cmath>

#include "engrave/core/check.h"

// Backwards from the end, a velocity is taken from what leads to the next one (reversal
// of time turns ReachableEndSpeeds into that) within the box; the box holds what can be
// reached from the start, so every choice has a way on both sides.
//
// A cubic over distance d in time T from v to w has the integral
//   J = 4 (v^2 + v w + w^2) / T - 12 d (v + w) / T^2 + 12 d^2 / T^3
// of its squared acceleration. With its neighbours u before and w behind fixed, the
// velocity v between steps (d, T) and (e, S) is best at
//   8 v (1 / T + 1 / S) = 12 (d / T^2 + e / S^2) - 4 (u / T + w / S),
// and J being convex, the best inside an interval is the nearest to it. Sweeps go to and
// fro.

namespace intaglio::motion {
namespace {

class OneAxis {
 public:
  OneAxis(int axis, double start_mm_s, std::span<const Vec3> steps_mm,
          std::span<const TimedStep> timed, const Limits& limits, double rate_hz,
          std::vector<Vec3>& ends_mm_s)
      : axis_(axis),
        start_mm_s_(start_mm_s),
        steps_mm_(steps_mm),
        timed_(timed),
        limits_(LimitsOf(limits, axis)),
        rate_hz_(rate_hz),
        ends_mm_s_(ends_mm_s) {}

  void Backwards() {
    std::size_t i = timed_.size() - 1;
    end(i) = Box(i).Clamp(steps_mm_[i][axis_] / Seconds(i));
    while (i-- > 0) {
      const SpeedInterval open = Intersection(Box(i), Before(i + 1));
      end(i) = open.Clamp(Best(i, steps_mm_[i][axis_] / Seconds(i)));
    }
  }

  void Sweep(bool forwards) {
    const std::size_t inner = timed_.size() - 1;
    for (std::size_t k = 0; k < inner; ++k) {
      const std::size_t i = forwards ? k : inner - 1 - k;
      const double best = Best(i, Start(i));
      if (CubicKeeps(i, Start(i), best) && CubicKeeps(i + 1, best, end(i + 1))) {
        end(i) = best;
        continue;
      }
      const SpeedInterval open = Intersection(Behind(i), Before(i + 1));
      if (!open.empty()) end(i) = open.Clamp(best);
    }
  }

 private:
  double& end(std::size_t i) { return ends_mm_s_[i][axis_]; }
  double Start(std::size_t i) { return i == 0 ? start_mm_s_ : end(i - 1); }
  double Seconds(std::size_t i) const { return timed_[i].ticks / rate_hz_; }
  const SpeedInterval& Box(std::size_t i) const { return timed_[i].box.axis[axis_]; }

  /// Whether the cubic of step i keeps the limits: what most points need, without a root.
  bool CubicKeeps(std::size_t i, double v, double w) const {
    const double seconds = Seconds(i);
    const double mean = steps_mm_[i][axis_] / seconds;
    const double most = limits_.max_acceleration_mm_s2 * seconds;
    // Bezier ordinates of the speed: v, the middle one, w.
    const double middle = 3 * mean - v - w;
    return std::abs(6 * mean - 4 * v - 2 * w) <= most &&
           std::abs(6 * mean - 2 * v - 4 * w) <= most &&
           std::abs(middle) <= limits_.max_speed_mm_s &&
           std::abs(w) <= limits_.max_speed_mm_s && std::abs(v) <= limits_.max_speed_mm_s;
  }
  /// Where step i can end, coming from its start.
  SpeedInterval Behind(std::size_t i) {
    const double v = Start(i);
    return ReachableEndSpeeds({v, v}, steps_mm_[i][axis_], Seconds(i), limits_);
  }
  /// Where step i can start, going to its end.
  SpeedInterval Before(std::size_t i) {
    const double v = end(i);
    return ReachableEndSpeeds({v, v}, steps_mm_[i][axis_], Seconds(i), limits_);
  }
  /// The best velocity between step i and the next, with `before` at the start of i.
  double Best(std::size_t i, double before) {
    const double t = 1 / Seconds(i), s = 1 / Seconds(i + 1);
    return (3 * (steps_mm_[i][axis_] * t * t + steps_mm_[i + 1][axis_] * s * s) -
            before * t - end(i + 1) * s) /
           (2 * (t + s));
  }

  int axis_;
  double start_mm_s_;
  std::span<const Vec3> steps_mm_;
  std::span<const TimedStep> timed_;
  AxisLimits limits_;
  double rate_hz_;
  std::vector<Vec3>& ends_mm_s_;
};

}  // namespace

void ChooseSpeeds(const Vec3& start_mm_s, std::span<const Vec3> steps_mm,
                  std::span<const TimedStep> timed, const Limits& limits, double rate_hz,
                  int sweeps, std::vector<Vec3>& ends_mm_s) {
  Require(steps_mm.size() == timed.size(), "{} steps and {} times", steps_mm.size(),
          timed.size());
  ends_mm_s.resize(timed.size());
  if (timed.empty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    OneAxis one(axis, start_mm_s[axis], steps_mm, timed, limits, rate_hz, ends_mm_s);
    one.Backwards();
    for (int sweep = 0; sweep < sweeps; ++sweep) one.Sweep(sweep % 2 == 0);
  }
}

}  // namespace intaglio::motion
