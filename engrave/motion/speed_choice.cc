#include "engrave/motion/speed_choice.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/motion/axis/jerk_reach.h"

// Backwards from the end, a velocity is chosen among those that lead to the next one
// (ReachableEndSpeeds with time reversed) within the box. The box holds the velocities
// that can be reached from the start, so every choice is feasible on both sides.
//
// A cubic over distance d in time T from v to w has the integral
//   J = 4 (v^2 + v w + w^2) / T - 12 d (v + w) / T^2 + 12 d^2 / T^3
// of its squared acceleration. With its neighbours u before and w behind fixed, the
// velocity v between steps (d, T) and (e, S) is best at
//   8 v (1 / T + 1 / S) = 12 (d / T^2 + e / S^2) - 4 (u / T + w / S),
// and J being convex, the best inside an interval is the nearest to it. Sweeps alternate
// in direction.

namespace intaglio::motion {
namespace {

/// x, y, z and a lane of zeros, which goes with two lanes or four at a time.
using Axes = Eigen::Array4d;

Axes AxesOf(const Vec3& v) { return {v.x(), v.y(), v.z(), 0}; }

class Way {
 public:
  Way(const Vec3& start_mm_s, std::span<const Vec3> steps_mm,
      std::span<const TimedStep> timed, bool near_walls,
      const std::vector<StepLimits>& choices, double rate_hz)
      : timed_(timed), near_walls_(near_walls), choices_(choices) {
    steps_.reserve(timed.size());
    for (std::size_t i = 0; i < timed.size(); ++i) {
      const StepLimits& limits = choices[timed[i].choice];
      const double seconds = timed[i].ticks * (1 / rate_hz);
      Axes largest = AxesOf(limits.planned.max_acceleration_mm_s2 * seconds);
      for (int axis = 0; axis < 3; ++axis) {
        if (limits.jerk_limited(axis)) largest[axis] = -1;
      }
      const double per_s = 1 / seconds;
      steps_.push_back({AxesOf(steps_mm[i]), AxesOf(steps_mm[i] * per_s), largest,
                        AxesOf(limits.planned.max_speed_mm_s), seconds, per_s});
    }
    speeds_.resize(timed.size() + 1);
    speeds_[0] = AxesOf(start_mm_s);
  }

  void Backwards() {
    const std::size_t last = steps_.size() - 1;
    speeds_[last + 1][3] = 0;
    for (int axis = 0; axis < 3; ++axis) {
      speeds_[last + 1][axis] = timed_[last].box.axis[axis].Clamp(0);
    }
    for (std::size_t i = last; i-- > 0;) {
      const Axes& next = speeds_[i + 2];
      const Axes best = Best(i, steps_[i].mean_mm_s);
      Axes& end = speeds_[i + 1];
      end[3] = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const SpeedEnds open = Intersection(EndsOf(timed_[i].box.axis[axis]),
                                            Reach(i + 1, axis, next[axis]));
        end[axis] = IntervalOf(open).Clamp(best[axis]);
      }
    }
  }

  void Sweep(bool forwards) {
    const std::size_t inner = steps_.size() - 1;
    for (std::size_t k = 0; k < inner; ++k) Improve(forwards ? k : inner - 1 - k);
  }

  void Write(std::vector<Vec3>& ends_mm_s) const {
    ends_mm_s.resize(steps_.size());
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      ends_mm_s[i] = speeds_[i + 1].head<3>().matrix();
    }
  }

 private:
  struct Step {
    Axes distance_mm;
    Axes mean_mm_s;
    Axes max_mm_s;  ///< Gained at full acceleration; < 0 where jerk is limited.
    Axes top_mm_s;
    double seconds;
    double per_s;
  };

  /// The best velocity between step i and the next, with `before` at the start of i.
  Axes Best(std::size_t i, const Axes& before) const {
    const double t = steps_[i].per_s, s = steps_[i + 1].per_s;
    return (3 * (steps_[i].mean_mm_s * t + steps_[i + 1].mean_mm_s * s) - before * t -
            speeds_[i + 2] * s) *
           (0.5 / (t + s));
  }

  void Improve(std::size_t i) {
    const Axes &start = speeds_[i], &next = speeds_[i + 2];
    const Axes best = Best(i, start);
    Axes excess = Excess(steps_[i], start, best).max(Excess(steps_[i + 1], best, next));
    if (near_walls_) {
      for (int axis = 0; axis < 3; ++axis) {
        if (!timed_[i].box.axis[axis].Contains(best[axis])) excess[axis] = 1;
      }
    }
    Axes& end = speeds_[i + 1];
    if (excess.maxCoeff() <= 0) {
      end = best;
      return;
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (excess[axis] <= 0) {
        end[axis] = best[axis];
        continue;
      }
      SpeedEnds open =
          Intersection(Reach(i, axis, start[axis]), Reach(i + 1, axis, next[axis]));
      if (near_walls_) open = Intersection(open, EndsOf(timed_[i].box.axis[axis]));
      if (!IsEmpty(open)) end[axis] = IntervalOf(open).Clamp(best[axis]);
    }
  }

  /// By how much the cubic of a step exceeds the limits, <= 0 where it keeps them.
  /// Without a root; enough for most points.
  [[gnu::always_inline]] static Axes Excess(const Step& step, const Axes& v,
                                            const Axes& w) {
    const Axes six = 6 * step.mean_mm_s;
    const Axes ends = (six - 4 * v - 2 * w).abs().max((six - 2 * v - 4 * w).abs());
    // Bezier ordinates of the speed: v, the middle one, w.
    const Axes middle = 3 * step.mean_mm_s - v - w;
    return (ends - step.max_mm_s)
        .max(middle.abs().max(v.abs()).max(w.abs()) - step.top_mm_s);
  }

  /// Where step i can end coming from `speed`, and where it can start going to it.
  SpeedEnds Reach(std::size_t i, int axis, double speed) const {
    const SpeedInterval at{speed, speed};
    const Step& step = steps_[i];
    const Limits& planned = choices_[timed_[i].choice].planned;
    if (step.max_mm_s[axis] < 0) {
      return EndsOf(ReachableEndSpeeds(at, step.distance_mm[axis], step.seconds,
                                       JerkLimitsOf(planned, axis)));
    }
    return AxisReach(step.distance_mm[axis], step.seconds, LimitsOf(planned, axis))
        .After(EndsOf(at));
  }

  std::span<const TimedStep> timed_;
  bool near_walls_;
  const std::vector<StepLimits>& choices_;
  std::vector<Step> steps_;
  std::vector<Axes> speeds_;  ///< At the start of each step and at the end of the last.
};

}  // namespace

void ChooseSpeeds(const Vec3& start_mm_s, std::span<const Vec3> steps_mm,
                  std::span<const TimedStep> timed, bool near_walls,
                  const std::vector<StepLimits>& choices, double rate_hz, int sweeps,
                  std::vector<Vec3>& ends_mm_s) {
  Require(steps_mm.size() == timed.size(), "{} steps and {} times", steps_mm.size(),
          timed.size());
  ends_mm_s.clear();
  if (timed.empty()) return;
  Way way(start_mm_s, steps_mm, timed, near_walls, choices, rate_hz);
  way.Backwards();
  for (int sweep = 0; sweep < sweeps; ++sweep) way.Sweep(sweep % 2 == 0);
  way.Write(ends_mm_s);
}

}  // namespace intaglio::motion
