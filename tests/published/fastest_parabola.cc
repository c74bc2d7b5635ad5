#include "tests/published/fastest_parabola.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"

namespace intaglio::motion {
namespace {

struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  bool empty() const { return low > high; }
};

/// Where |offset + slope a| <= bound.
Range WhereWithin(double offset, double slope, double bound) {
  if (slope == 0) return std::abs(offset) <= bound ? Range{} : Range{1, -1};
  const double one = (-bound - offset) / slope, other = (bound - offset) / slope;
  return {std::min(one, other), std::max(one, other)};
}

class Track {
 public:
  Track(double b_mm, double h_mm, const ForcedAxis& lift, const ForcedAxis& along)
      : b_mm_(b_mm), k_per_mm_(h_mm / (b_mm * b_mm)), lift_(lift), along_(along) {}

  /// The accelerations of x5 that both forces allow.
  Range Accelerations(double x5_mm, double x6_mm_s) const {
    const double m = -2 * k_per_mm_ * (x5_mm - b_mm_);
    const Range by_along =
        WhereWithin(-along_.alpha_per_s * x6_mm_s / along_.beta_mm_s2_n,
                    1 / along_.beta_mm_s2_n, along_.max_force_n);
    const double curved = -2 * k_per_mm_ * x6_mm_s * x6_mm_s;
    const Range by_lift =
        WhereWithin((curved - lift_.alpha_per_s * m * x6_mm_s) / lift_.beta_mm_s2_n,
                    m / lift_.beta_mm_s2_n, lift_.max_force_n);
    return {std::max(by_along.low, by_lift.low), std::min(by_along.high, by_lift.high)};
  }

  /// The largest speed that can be held for an instant, by bisection: at rest any force
  /// is free, and the forces of a speed grow with it.
  double MaxSpeed(double x5_mm) const {
    double low = 0, high = 1;
    while (!Accelerations(x5_mm, high).empty() && high < 1e9) high *= 2;
    if (high >= 1e9) return high;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (Accelerations(x5_mm, middle).empty() ? high : low) = middle;
    }
    return low;
  }

  /// The square of the speed after a step: d(x6^2) = 2 a dx, by the midpoint. `sign` 1:
  /// onwards with the largest acceleration; -1: backwards with the smallest.
  double Next(double x5_mm, double square, double step_mm, int sign) const {
    const auto acceleration = [&](double at_mm, double q) {
      const Range range = Accelerations(at_mm, std::sqrt(std::max(0.0, q)));
      if (range.empty()) return 0.0;
      return sign > 0 ? range.high : -range.low;
    };
    const double half = square + step_mm * acceleration(x5_mm, square);
    const double next =
        square + 2 * step_mm * acceleration(x5_mm + sign * 0.5 * step_mm, half);
    return std::max(0.0, next);
  }

 private:
  double b_mm_, k_per_mm_;
  ForcedAxis lift_, along_;
};

void CheckAxis(const ForcedAxis& axis) {
  Require(axis.alpha_per_s <= 0 && axis.beta_mm_s2_n > 0 && axis.max_force_n > 0,
          "alpha {} 1/s must not be positive, beta {} mm/(s^2 N) and the force {} N must "
          "be positive",
          axis.alpha_per_s, axis.beta_mm_s2_n, axis.max_force_n);
}

/// The squares of the speeds at the places: the lower envelope.
std::vector<double> Squares(const Track& track, const std::vector<double>& x5_mm,
                            double step_mm) {
  std::vector<double> square(x5_mm.size());
  for (std::size_t i = 0; i < square.size(); ++i) {
    const double speed = track.MaxSpeed(x5_mm[i]);
    square[i] = speed * speed;
  }
  square.front() = square.back() = 0;
  for (std::size_t i = 0; i + 1 < square.size(); ++i) {
    square[i + 1] = std::min(square[i + 1], track.Next(x5_mm[i], square[i], step_mm, 1));
  }
  for (std::size_t i = square.size() - 1; i > 0; --i) {
    square[i - 1] = std::min(square[i - 1], track.Next(x5_mm[i], square[i], step_mm, -1));
  }
  return square;
}

}  // namespace

Result<FastestMotion> FastestAlongParabola(double half_width_mm, double height_mm,
                                           const ForcedAxis& lift,
                                           const ForcedAxis& along, int steps) {
  Require(half_width_mm > 0 && height_mm >= 0,
          "half width {} mm must be positive, height {} mm not negative", half_width_mm,
          height_mm);
  Require(steps >= 100 && steps <= 1'000'000, "steps must be 100..1000000, are {}",
          steps);
  CheckAxis(lift);
  CheckAxis(along);
  const Track track(half_width_mm, height_mm, lift, along);
  const double step_mm = 2 * half_width_mm / steps;
  FastestMotion motion;
  for (int i = 0; i <= steps; ++i) motion.x5_mm.push_back(step_mm * i);
  const std::vector<double> square = Squares(track, motion.x5_mm, step_mm);
  for (std::size_t i = 0; i + 1 < square.size(); ++i) {
    const double mean = 0.5 * (std::sqrt(square[i]) + std::sqrt(square[i + 1]));
    if (!(mean > 0)) {
      return Fail(ErrorCode::kUnsupported,
                  "the forces do not move the stage along the parabola");
    }
    motion.seconds += step_mm / mean;
    motion.x5_mm_s2.push_back((square[i + 1] - square[i]) / (2 * step_mm));
  }
  for (const double q : square) motion.x6_mm_s.push_back(std::sqrt(q));
  return motion;
}

}  // namespace intaglio::motion
