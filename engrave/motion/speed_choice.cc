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

template <bool kPlain>
class Way {
 public:
  Way(const Vec3& start_mm_s, std::span<const Vec3> steps_mm,
      std::span<const TimedStep> timed, bool near_walls,
      const std::vector<StepLimits>& choices, double rate_hz,
      std::vector<Vec3>& ends_mm_s)
      : start_mm_s_(start_mm_s),
        steps_mm_(steps_mm),
        timed_(timed),
        choices_(choices),
        plain_{LimitsOf(choices[0].planned, 0), LimitsOf(choices[0].planned, 1),
               LimitsOf(choices[0].planned, 2)},
        near_walls_(near_walls),
        tick_s_(1 / rate_hz),
        ends_mm_s_(ends_mm_s) {}

  void Backwards() {
    std::size_t i = timed_.size() - 1;
    for (int axis = 0; axis < 3; ++axis) {
      ends_mm_s_[i][axis] = timed_[i].box.axis[axis].Clamp(0);
    }
    while (i-- > 0) {
      const Weights weights = WeightsAt(i);
      for (int axis = 0; axis < 3; ++axis) {
        const SpeedInterval open =
            Intersection(timed_[i].box.axis[axis], Before(i + 1, axis));
        const double before = steps_mm_[i][axis] * weights.per_s;
        ends_mm_s_[i][axis] = open.Clamp(Best(i, axis, weights, before));
      }
    }
  }

  void Sweep(bool forwards) {
    const std::size_t inner = timed_.size() - 1;
    for (std::size_t k = 0; k < inner; ++k) {
      const std::size_t i = forwards ? k : inner - 1 - k;
      const Weights weights = WeightsAt(i);
      for (int axis = 0; axis < 3; ++axis) Improve(i, axis, weights);
    }
  }

 private:
  struct Weights {
    double per_s;       ///< 1 / T
    double next_per_s;  ///< 1 / S
    double whole_s;     ///< 1 / (2 (1 / T + 1 / S))
  };

  Weights WeightsAt(std::size_t i) const {
    const double t = 1 / Seconds(i), s = 1 / Seconds(i + 1);
    return {t, s, 0.5 / (t + s)};
  }
  const StepLimits& LimitsAt(std::size_t i) const { return choices_[timed_[i].choice]; }
  double Seconds(std::size_t i) const { return timed_[i].ticks * tick_s_; }
  double Start(std::size_t i, int axis) const {
    return i == 0 ? start_mm_s_[axis] : ends_mm_s_[i - 1][axis];
  }

  /// The best velocity between step i and the next, with `before` at the start of i.
  double Best(std::size_t i, int axis, const Weights& w, double before) const {
    const double t = w.per_s, s = w.next_per_s;
    return (3 * (steps_mm_[i][axis] * t * t + steps_mm_[i + 1][axis] * s * s) -
            before * t - ends_mm_s_[i + 1][axis] * s) *
           w.whole_s;
  }

  void Improve(std::size_t i, int axis, const Weights& weights) {
    const double start = Start(i, axis), next = ends_mm_s_[i + 1][axis];
    const double best = Best(i, axis, weights, start);
    double& end = ends_mm_s_[i][axis];
    const SpeedInterval& box = timed_[i].box.axis[axis];
    if ((kPlain || !near_walls_ || box.Contains(best)) &&
        CubicKeeps(i, axis, weights.per_s, start, best) &&
        CubicKeeps(i + 1, axis, weights.next_per_s, best, next)) {
      end = best;
      return;
    }
    SpeedInterval open = Intersection(Behind(i, axis, start), Before(i + 1, axis));
    if (!kPlain && near_walls_) open = Intersection(open, box);
    if (!open.empty()) end = open.Clamp(best);
  }

  /// Whether the cubic of step i keeps the limits: what most points need, without a root.
  bool CubicKeeps(std::size_t i, int axis, double per_s, double v, double w) const {
    if (!kPlain && LimitsAt(i).jerk_limited(axis)) return false;
    const AxisLimits limits = kPlain ? plain_[axis] : LimitsOf(LimitsAt(i).planned, axis);
    const double mean = steps_mm_[i][axis] * per_s;
    const double most = limits.max_acceleration_mm_s2 * Seconds(i);
    const double top = limits.max_speed_mm_s;
    // Bezier ordinates of the speed: v, the middle one, w.
    const double middle = 3 * mean - v - w;
    return std::abs(6 * mean - 4 * v - 2 * w) <= most &&
           std::abs(6 * mean - 2 * v - 4 * w) <= most && std::abs(middle) <= top &&
           std::abs(v) <= top && std::abs(w) <= top;
  }
  /// Where step i can end, coming from `start`.
  SpeedInterval Behind(std::size_t i, int axis, double start) const {
    return Reach(i, axis, start);
  }
  /// Where step i can start, going to its end.
  SpeedInterval Before(std::size_t i, int axis) const {
    return Reach(i, axis, ends_mm_s_[i][axis]);
  }
  SpeedInterval Reach(std::size_t i, int axis, double speed) const {
    const SpeedInterval from{speed, speed};
    if constexpr (kPlain) {
      return ReachableEndSpeeds(from, steps_mm_[i][axis], Seconds(i), plain_[axis]);
    }
    return ReachableEndSpeeds(from, steps_mm_[i][axis], Seconds(i), axis, LimitsAt(i));
  }

  Vec3 start_mm_s_;
  std::span<const Vec3> steps_mm_;
  std::span<const TimedStep> timed_;
  const std::vector<StepLimits>& choices_;
  AxisLimits plain_[3];  ///< Of all steps, where they are plain.
  bool near_walls_;
  double tick_s_;
  std::vector<Vec3>& ends_mm_s_;
};

}  // namespace

void ChooseSpeeds(const Vec3& start_mm_s, std::span<const Vec3> steps_mm,
                  std::span<const TimedStep> timed, bool near_walls,
                  const std::vector<StepLimits>& choices, double rate_hz, int sweeps,
                  std::vector<Vec3>& ends_mm_s) {
  Require(steps_mm.size() == timed.size(), "{} steps and {} times", steps_mm.size(),
          timed.size());
  ends_mm_s.resize(timed.size());
  if (timed.empty()) return;
  const auto choose = [&](auto way) {
    way.Backwards();
    for (int sweep = 0; sweep < sweeps; ++sweep) way.Sweep(sweep % 2 == 0);
  };
  if (!near_walls && IsPlain(choices)) {
    choose(
        Way<true>(start_mm_s, steps_mm, timed, near_walls, choices, rate_hz, ends_mm_s));
  } else {
    choose(
        Way<false>(start_mm_s, steps_mm, timed, near_walls, choices, rate_hz, ends_mm_s));
  }
}

}  // namespace intaglio::motion
