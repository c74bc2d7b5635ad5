#include "engrave/motion/sweep_course.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engrave/core/check.h"

// With u_k = (z_k - z_{k-1}) / T_k and 1 / t_k = 2 / (T_k + T_{k+1}), as in
// point_shift.cc,
//   E(z) = (u_1 - v_0)^2 2 / T_1 + sum (u_{k+1} - u_k)^2 / t_k
// is quadratic, of five diagonals. Least E within the tube low <= z <= high: alternating
// directions (Boyd 2011, Distributed Optimization and Statistical Learning via ADMM, ch.
// 5), one factorization and some passes:
//   z = argmin E(z) + sum w (z - y + d)^2,   y = clamp(z + d),   d += z - y.
// It begins with the shortest way through the tube, which has the right places over long
// times; the passes round its corners, over about 1 / omega with w = T omega^4.

namespace intaglio::motion {
namespace {

/// The tube of the passes is narrower by this share on each side, so that a smooth course
/// that is nearly inside is inside the tube itself.
constexpr double kMargin = 0.03;
constexpr int kMinPasses = 10, kMaxPasses = 240;
/// After so many passes corners are rounded over half of the time.
constexpr int kPassesPerWeight = 40;
constexpr double kStiffer = 16;
/// Speeds up alternating directions; 1.5 to 1.8 in Boyd 2011, ch. 3.4.3.
constexpr double kOverRelaxation = 1.6;
/// A corner is rounded over as long as the axis takes to change its mean speed, and over
/// some steps at least.
constexpr double kRoundingSteps = 4;

}  // namespace

// The funnel of lines of sight from the last corner: when it closes, the side that closed
// it is the next corner.
void SweepCourse::TakeTautString(const SweepStart& start) {
  const std::size_t count = times_s_.size();
  inside_mm_.resize(count);
  double from_s = 0, from_mm = start.position_mm;
  std::size_t next = 0;  // the first place not yet on the string
  while (next < count) {
    double low = -INFINITY, high = INFINITY;
    std::size_t at_low = next, at_high = next, end = next;
    double slope = 0;
    for (;; ++end) {
      if (end == count) {
        slope = std::clamp(0.0, low, high);
        break;
      }
      const double gone_s = times_s_[end] - from_s;
      const double to_low = (low_mm_[end] - from_mm) / gone_s;
      const double to_high = (high_mm_[end] - from_mm) / gone_s;
      if (to_low > high) {
        slope = high;
        end = at_high + 1;
        break;
      }
      if (to_high < low) {
        slope = low;
        end = at_low + 1;
        break;
      }
      if (to_low >= low) {
        low = to_low;
        at_low = end;
      }
      if (to_high <= high) {
        high = to_high;
        at_high = end;
      }
    }
    for (; next < end; ++next) {
      inside_mm_[next] = std::clamp(from_mm + slope * (times_s_[next] - from_s),
                                    low_mm_[next], high_mm_[next]);
    }
    from_s = times_s_[end - 1];
    from_mm = inside_mm_[end - 1];
  }
}

void SweepCourse::AddBending(const SweepStart& start, std::span<const double> seconds) {
  const std::size_t count = seconds.size();
  diagonal_.assign(count, 0);
  beside_.assign(count, 0);
  beyond_.assign(count, 0);
  linear_.assign(count, 0);
  // w (a z_{k-1} + b z_k + c z_{k+1})^2 with places before the first known.
  for (std::size_t k = 0; k < count; ++k) {
    const double c = 1 / seconds[k];
    if (k == 0) {
      const double w = 4 / seconds[0];
      diagonal_[0] += w * c * c;
      linear_[0] += w * c * (c * start.position_mm + start.speed_mm_s);
      continue;
    }
    const double a = 1 / seconds[k - 1], b = -a - c;
    const double w = 4 / (seconds[k - 1] + seconds[k]);
    diagonal_[k] += w * c * c;
    diagonal_[k - 1] += w * b * b;
    beside_[k - 1] += w * b * c;
    if (k == 1) {
      linear_[0] -= w * b * a * start.position_mm;
      linear_[1] -= w * c * a * start.position_mm;
      continue;
    }
    diagonal_[k - 2] += w * a * a;
    beside_[k - 2] += w * a * b;
    beyond_[k - 2] += w * a * c;
  }
}

void SweepCourse::Factorize() {
  const std::size_t count = diagonal_.size();
  pivot_.resize(count);
  left_.assign(count, 0);
  left_left_.assign(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    pivot_[i] = diagonal_[i] + weight_[i];
    if (i >= 2) {
      left_left_[i] = beyond_[i - 2] / pivot_[i - 2];
      pivot_[i] -= left_left_[i] * beyond_[i - 2];
    }
    if (i >= 1) {
      double row = beside_[i - 1];
      if (i >= 2) row -= left_left_[i] * left_[i - 1] * pivot_[i - 2];
      left_[i] = row / pivot_[i - 1];
      pivot_[i] -= left_[i] * row;
    }
  }
}

void SweepCourse::BackSubstitute(std::vector<double>& values) const {
  const std::size_t count = values.size();
  for (std::size_t i = 1; i < count; ++i) {
    values[i] -= left_[i] * values[i - 1];
    if (i >= 2) values[i] -= left_left_[i] * values[i - 2];
  }
  for (std::size_t i = 0; i < count; ++i) values[i] /= pivot_[i];
  for (std::size_t i = count; i-- > 0;) {
    if (i + 1 < count) values[i] -= left_[i + 1] * values[i + 1];
    if (i + 2 < count) values[i] -= left_left_[i + 2] * values[i + 2];
  }
}

/// One pass; how far the smooth course leaves the narrower tube, mm.
double SweepCourse::StepTowardsTube() {
  const std::size_t count = weight_.size();
  for (std::size_t i = 0; i < count; ++i) {
    smooth_mm_[i] = linear_[i] + weight_[i] * (inside_mm_[i] - dual_mm_[i]);
  }
  BackSubstitute(smooth_mm_);
  double beyond_mm = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double relaxed_mm =
        kOverRelaxation * smooth_mm_[i] + (1 - kOverRelaxation) * inside_mm_[i];
    const double inside_mm =
        std::clamp(relaxed_mm + dual_mm_[i], low_mm_[i], high_mm_[i]);
    dual_mm_[i] += relaxed_mm - inside_mm;
    inside_mm_[i] = inside_mm;
    beyond_mm =
        std::max({beyond_mm, low_mm_[i] - smooth_mm_[i], smooth_mm_[i] - high_mm_[i]});
  }
  return beyond_mm;
}

/// Greater weights reach the tube in fewer passes; the multipliers w d stay.
void SweepCourse::Stiffen() {
  for (double& weight : weight_) weight *= kStiffer;
  for (double& dual_mm : dual_mm_) dual_mm /= kStiffer;
  Factorize();
}

void SweepCourse::Solve(const SweepStart& start, std::span<const double> targets_mm,
                        std::span<const double> seconds, double tolerance_mm,
                        double acceleration_mm_s2, bool to_last,
                        std::vector<double>& places_mm) {
  Require(targets_mm.size() == seconds.size(), "{} places have {} times",
          targets_mm.size(), seconds.size());
  Require(tolerance_mm >= 0 && acceleration_mm_s2 > 0,
          "tolerance_mm {} must not be negative, acceleration_mm_s2 {} positive",
          tolerance_mm, acceleration_mm_s2);
  const std::size_t count = targets_mm.size();
  places_mm.assign(targets_mm.begin(), targets_mm.end());
  if (count == 0 || tolerance_mm == 0) return;
  times_s_.resize(count);
  std::partial_sum(seconds.begin(), seconds.end(), times_s_.begin());
  const double narrow_mm = (1 - kMargin) * tolerance_mm;
  low_mm_.resize(count);
  high_mm_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double half_mm = to_last && i + 1 == count ? 0 : narrow_mm;
    low_mm_[i] = targets_mm[i] - half_mm;
    high_mm_[i] = targets_mm[i] + half_mm;
  }
  TakeTautString(start);
  double way_mm = std::abs(inside_mm_[0] - start.position_mm);
  for (std::size_t i = 1; i < count; ++i) {
    way_mm += std::abs(inside_mm_[i] - inside_mm_[i - 1]);
  }
  const double step_s = times_s_.back() / static_cast<double>(count);
  const double rounding_s =
      std::max(kRoundingSteps * step_s, way_mm / times_s_.back() / acceleration_mm_s2);
  AddBending(start, seconds);
  weight_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    weight_[i] = 2 * seconds[i] / std::pow(rounding_s, 4);
  }
  Factorize();
  dual_mm_.assign(count, 0);
  smooth_mm_.resize(count);
  const double margin_mm = tolerance_mm - narrow_mm;
  for (int pass = 1; pass <= kMaxPasses; ++pass) {
    if (StepTowardsTube() < 0.5 * margin_mm && pass > kMinPasses) break;
    if (pass % kPassesPerWeight == 0) Stiffen();
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double half_mm = to_last && i + 1 == count ? 0 : tolerance_mm;
    places_mm[i] =
        std::clamp(smooth_mm_[i], targets_mm[i] - half_mm, targets_mm[i] + half_mm);
  }
}

}  // namespace intaglio::motion
