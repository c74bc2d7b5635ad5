#include "engrave/motion/step_course.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/motion/axis/jerk_reach.h"
#include "engrave/motion/segments/segment.h"

// With first and last fixed, an axis cruises at the speed that still goes the whole way,
// be they arcs of constant acceleration or symmetrical pulses of it:
//   d = (v + c) f / 2 + c (T - f - l) + (c + w) l / 2
//   c = (d - v f / 2 - w l / 2) / (T - (f + l) / 2).
// Two arcs: the shorter one is made longer by e < grid. It then needs less acceleration
// than before, and the other at most 4 e / T of it more.
// With a cruise: the longer one is made longer. For it, too, less acceleration is enough,
// and the shorter one is solved again, now from the other's rounded time f,
//   x = c - w,  l = |x| / a,  x (T - f / 2) - x |x| / (2 a) = d - v f / 2 - w (T - f /
//   2),
// before it is made longer in turn, which raises no acceleration by more than e / T.
//
// Pulses: the nodes of the acceleration, a broken line, go to the grid, and the values
// there are corrected so that speed and distance are what they should be. With the hat
// functions of the nodes these are linear in the values,
//   w - v = sum G a,   d - v T = sum M a,
// and of all corrections that with the least sum of squares is taken, each divided by
// the shorter time to a neighbour: what it adds to the jerk.

namespace intaglio::motion {
namespace {

/// l of the derivation: `near` is the speed at the end whose arc has its time.
double OtherArc(double near, double far, double d, double near_s, double seconds,
                double acceleration) {
  const double p = seconds - 0.5 * near_s;
  const double q = d - 0.5 * near * near_s - far * p;
  const double root = std::sqrt(std::max(0.0, p * p - 2 * std::abs(q) / acceleration));
  return 2 * std::abs(q) / ((p + root) * acceleration);
}

bool CubicFits(double v, double w, double d, double seconds, const AxisLimits& limits) {
  const double a = (6 * d / seconds - 4 * v - 2 * w) / seconds;
  const double b = (-6 * d / seconds + 2 * v + 4 * w) / seconds;
  if (std::max(std::abs(a), std::abs(b)) > limits.max_acceleration_mm_s2) return false;
  // The acceleration falls linearly from a to b; where it is 0 the speed is extreme.
  if ((a > 0) == (b > 0)) return true;
  const double extreme = v + 0.5 * a * a * seconds / (a - b);
  return std::abs(extreme) <= limits.max_speed_mm_s;
}

/// The acceleration of one axis over a step, 0 at both ends: a broken line.
class AccelerationNodes {
 public:
  explicit AccelerationNodes(double subtick_s) : subtick_s_(subtick_s) { Add(0, 0); }

  std::size_t count() const { return count_; }
  std::uint64_t at(std::size_t k) const { return at_[k]; }
  double acceleration(std::size_t k) const { return acceleration_[k]; }

  /// The trapezoid with ramps as long as the limits allow, but for what would need more
  /// than the limits. With `split` its longest parts get a node more, to be corrected.
  void AddPulse(std::uint64_t begin, std::uint64_t end, double gain_mm_s, bool split,
                std::uint64_t grid, const JerkLimits& limits) {
    const std::uint64_t duration = end - begin;
    if (duration == 0) return;
    const double all = static_cast<double>(duration);
    const double longest = std::min(
        std::max(all - std::abs(gain_mm_s) / limits.max_acceleration_mm_s2 / subtick_s_,
                 limits.max_acceleration_mm_s2 / limits.max_jerk_mm_s3 / subtick_s_),
        0.5 * all);
    const std::uint64_t ramp =
        std::max(grid, static_cast<std::uint64_t>(longest) / grid * grid);
    const double ramp_s = static_cast<double>(ramp) * subtick_s_;
    const double grid_s = static_cast<double>(grid) * subtick_s_;
    // The time by which a full ramp is shortened to fit the grid is kept in reserve.
    const double jerk = limits.max_jerk_mm_s3 * (1 + grid_s * limits.max_jerk_mm_s3 /
                                                         limits.max_acceleration_mm_s2);
    const double largest = std::min(limits.max_acceleration_mm_s2, jerk * ramp_s);
    const double peak = std::copysign(
        std::min(std::abs(gain_mm_s) / ((all * subtick_s_) - ramp_s), largest),
        gain_mm_s);
    const std::uint64_t half = ramp / (2 * grid) * grid;
    const double half_peak = peak * static_cast<double>(half) / static_cast<double>(ramp);
    const bool split_flat = split && duration > 3 * ramp;
    const bool split_ramps = split && !split_flat;
    Add(begin, 0);
    if (split_ramps) Add(begin + half, half_peak);
    Add(begin + ramp, peak);
    if (split_flat) Add(begin + duration / (2 * grid) * grid, peak);
    Add(end - ramp, peak);
    if (split_ramps) Add(end - half, half_peak);
    Add(end, 0);
  }

  void Close(std::uint64_t total) { Add(total, 0); }

  void Correct(double gain_mm_s, double lag_mm) {
    const auto seconds = [&](std::size_t from, std::size_t to) {
      return static_cast<double>(at_[to] - at_[from]) * subtick_s_;
    };
    std::array<double, kMax> gain{}, lag{}, weight{};
    double gg = 0, gm = 0, mm = 0;
    const std::size_t end = count_ - 1;
    for (std::size_t k = 1; k < end; ++k) {
      const double before = seconds(k - 1, k), behind = seconds(k, k + 1);
      const double left = seconds(k, end);
      gain[k] = 0.5 * (before + behind);
      lag[k] = gain[k] * left + (before * before - behind * behind) / 6;
      if (!IsLongCruise(k - 1, k) && !IsLongCruise(k, k + 1)) {
        weight[k] = std::min(before, behind) * std::min(before, behind);
      }
      gain_mm_s -= gain[k] * acceleration_[k];
      lag_mm -= lag[k] * acceleration_[k];
      gg += weight[k] * gain[k] * gain[k];
      gm += weight[k] * gain[k] * lag[k];
      mm += weight[k] * lag[k] * lag[k];
    }
    const double determinant = gg * mm - gm * gm;
    const double by_gain = (gain_mm_s * mm - lag_mm * gm) / determinant;
    const double by_lag = (lag_mm * gg - gain_mm_s * gm) / determinant;
    for (std::size_t k = 1; k < end; ++k) {
      acceleration_[k] += weight[k] * (by_gain * gain[k] + by_lag * lag[k]);
    }
  }

 private:
  static constexpr std::size_t kMax = StepCourse::kMaxPieces + 1;

  void Add(std::uint64_t at, double acceleration) {
    if (count_ > 0 && at <= at_[count_ - 1]) return;
    at_[count_] = at;
    acceleration_[count_++] = acceleration;
  }

  /// A long cruise stays a cruise: over a long time even the smallest acceleration would
  /// have an effect.
  bool IsLongCruise(std::size_t from, std::size_t to) const {
    return acceleration_[from] == 0 && acceleration_[to] == 0 &&
           at_[to] - at_[from] > at_[count_ - 1] / 8;
  }

  double subtick_s_;
  std::size_t count_ = 0;
  std::array<std::uint64_t, kMax> at_;
  std::array<double, kMax> acceleration_;
};

}  // namespace

StepCourse::StepCourse(const AxisStep& step, int axis, const StepLimits& limits,
                       double rate_hz)
    : step_(step),
      subtick_s_(1 / (kSubticksPerTick * rate_hz)),
      grid_(limits.grid_subticks) {
  const bool jerk_limited = limits.jerk_limited(axis);
  const auto take = [&](bool hardest) {
    count_ = 0;
    if (jerk_limited)
      TakePulses(limits, axis, hardest);
    else
      TakeArcs(limits.planned, axis, hardest);
  };
  // The travel, or the points themselves where they lie beyond it.
  const double end_mm = step.start_mm + step.distance_mm;
  const double lo_mm =
      std::min({limits.whole.travel_mm.min_mm[axis], step.start_mm, end_mm});
  const double hi_mm =
      std::max({limits.whole.travel_mm.max_mm[axis], step.start_mm, end_mm});
  // An axis gets at most half the way it could go in the time beyond its ends.
  const double beyond_mm =
      0.5 * Seconds(step.subticks) * limits.whole.max_speed_mm_s[axis];
  const bool open = lo_mm <= std::min(step.start_mm, end_mm) - beyond_mm &&
                    std::max(step.start_mm, end_mm) + beyond_mm <= hi_mm;
  const bool cubic =
      !jerk_limited && CubicFits(step.start_mm_s, step.end_mm_s, step.distance_mm,
                                 Seconds(step.subticks), LimitsOf(limits.whole, axis));
  if (cubic) {
    Add(step.subticks, {step.distance_mm, step.end_mm_s});
    if (open || StaysWithin(lo_mm, hi_mm)) return;
  }
  take(false);
  if (!open && !StaysWithin(lo_mm, hi_mm)) take(true);
}

double StepCourse::Seconds(std::uint64_t subticks) const {
  return static_cast<double>(subticks) * subtick_s_;
}

void StepCourse::Add(std::uint64_t end, State at_end) {
  const std::uint64_t begin = count_ == 0 ? 0 : pieces_[count_ - 1].end;
  if (end > begin) pieces_[count_++] = {end, at_end};
}

std::uint64_t StepCourse::OnGrid(double seconds, std::uint64_t grid) const {
  const double steps = seconds / (subtick_s_ * static_cast<double>(grid));
  // Rounded up; std::ceil is a call.
  const auto whole = static_cast<std::int64_t>(steps);
  const std::int64_t up = whole + (static_cast<double>(whole) < steps ? 1 : 0);
  return grid * static_cast<std::uint64_t>(up);
}

double StepCourse::CruiseFor(std::uint64_t first, std::uint64_t last) const {
  const double first_s = Seconds(first), last_s = Seconds(last);
  return (step_.distance_mm - 0.5 * step_.start_mm_s * first_s -
          0.5 * step_.end_mm_s * last_s) /
         (Seconds(step_.subticks) - 0.5 * (first_s + last_s));
}

// Where the cruise is so short that the grid has no room for it, two arcs go the way:
// what they pass the planned speed by is within its reserve.
StepCourse::ArcTimes StepCourse::ArcsOnGrid(const Arcs& arcs) const {
  const double v = step_.start_mm_s, w = step_.end_mm_s, d = step_.distance_mm;
  const std::uint64_t total = step_.subticks;
  const double seconds = Seconds(total);
  const bool first_is_longer = arcs.first_s > arcs.last_s;
  const auto in_order = [&](std::uint64_t longer, std::uint64_t shorter) {
    return first_is_longer ? ArcTimes{longer, shorter} : ArcTimes{shorter, longer};
  };
  if (arcs.first_s + arcs.last_s < seconds * (1 - 1e-12)) {
    const std::uint64_t longer = OnGrid(std::max(arcs.first_s, arcs.last_s), grid_);
    const double longer_s = Seconds(longer);
    const double shorter_s =
        first_is_longer
            ? OtherArc(v, w, d, longer_s, seconds, arcs.peak_acceleration_mm_s2)
            : OtherArc(w, v, d, longer_s, seconds, arcs.peak_acceleration_mm_s2);
    const std::uint64_t shorter = OnGrid(shorter_s, grid_);
    if (longer + shorter <= total) return in_order(longer, shorter);
    return ArcsOnGrid(GentlestArcs(v, w, d, seconds, kUnlimited));
  }
  const std::uint64_t shorter =
      std::min(OnGrid(std::min(arcs.first_s, arcs.last_s), grid_), total);
  return in_order(total - shorter, shorter);
}

void StepCourse::TakeArcs(const Limits& planned, int axis, bool hardest) {
  const double v = step_.start_mm_s, w = step_.end_mm_s, d = step_.distance_mm;
  const std::uint64_t total = step_.subticks;
  const AxisLimits limits = LimitsOf(planned, axis);
  const auto [first, last] =
      ArcsOnGrid(hardest ? HardestArcs(v, w, d, Seconds(total), limits)
                         : GentlestArcs(v, w, d, Seconds(total), limits.max_speed_mm_s));
  const double cruise = CruiseFor(first, last);
  const double first_s = Seconds(first), hold_s = Seconds(total - first - last);
  const double first_mm = 0.5 * (v + cruise) * first_s;
  Add(first, {first_mm, cruise});
  Add(total - last, {first_mm + cruise * hold_s, cruise});
  Add(total, {d, w});
}

void StepCourse::TakePulses(const StepLimits& limits, int axis, bool hardest) {
  const double v = step_.start_mm_s, w = step_.end_mm_s, d = step_.distance_mm;
  const std::uint64_t total = step_.subticks, unit = 2 * grid_;
  const JerkLimits planned = JerkLimitsOf(limits.planned, axis);
  const Pulses pulses = hardest ? HardestPulses(v, w, d, Seconds(total), planned)
                                : GentlestPulses(v, w, d, Seconds(total), planned);
  if (pulses.share < 1e-9) return Add(total, {d, w});
  const auto at_most = [&](std::uint64_t longest, double pulse_s) {
    return std::min(OnGrid(pulse_s, unit), longest);
  };
  std::uint64_t first = at_most(total, pulses.first_s);
  std::uint64_t last = at_most(total - first, pulses.last_s);
  // A pulse made longer changes the cruise, which then has to be reached from an end that
  // was at it.
  const double change = CruiseFor(first, last) - (first == 0 ? v : w);
  if (first == 0) first = at_most(total - last, PulseSeconds(std::abs(change), planned));
  if (last == 0) last = at_most(total - first, PulseSeconds(std::abs(change), planned));
  const double cruise = CruiseFor(first, last);
  AccelerationNodes nodes(subtick_s_);
  nodes.AddPulse(0, first, cruise - v, first > last, grid_, planned);
  nodes.AddPulse(total - last, total, w - cruise, first <= last, grid_, planned);
  nodes.Close(total);
  // The second time for the rounding of the first.
  for (int i = 0; i < 2; ++i) nodes.Correct(w - v, d - v * Seconds(total));
  State at{0, v};
  for (std::size_t k = 1; k < nodes.count(); ++k) {
    const double t = Seconds(nodes.at(k) - nodes.at(k - 1));
    const double a = nodes.acceleration(k - 1), b = nodes.acceleration(k);
    at.gone_mm += t * (at.speed_mm_s + t * (2 * a + b) / 6);
    at.speed_mm_s += 0.5 * t * (a + b);
    Add(nodes.at(k), at);
  }
  pieces_[count_ - 1].at_end = {d, w};
}

StepCourse::Cubic StepCourse::CubicOf(std::size_t piece) const {
  const std::uint64_t begin = piece == 0 ? 0 : pieces_[piece - 1].end;
  const State from = piece == 0 ? State{0, step_.start_mm_s} : pieces_[piece - 1].at_end;
  const State& to = pieces_[piece].at_end;
  const double t = Seconds(pieces_[piece].end - begin);
  const double mean = (to.gone_mm - from.gone_mm) / t;
  return {begin, from, t, (6 * mean - 4 * from.speed_mm_s - 2 * to.speed_mm_s) / t,
          6 * (from.speed_mm_s + to.speed_mm_s - 2 * mean) / (t * t)};
}

StepCourse::State StepCourse::Cubic::At(double t) const {
  return {from.gone_mm + t * (from.speed_mm_s + t * (0.5 * acceleration + t * jerk / 6)),
          from.speed_mm_s + t * (acceleration + 0.5 * t * jerk)};
}

StepCourse::State StepCourse::At(std::uint64_t subticks) const {
  std::size_t piece = 0;
  while (pieces_[piece].end < subticks) ++piece;
  if (pieces_[piece].end == subticks) return pieces_[piece].at_end;
  const Cubic cubic = CubicOf(piece);
  return cubic.At(Seconds(subticks - cubic.begin));
}

bool StepCourse::StaysWithin(double lo_mm, double hi_mm) const {
  constexpr double kRoundingMm = 1e-12;
  for (std::size_t piece = 0; piece < count_; ++piece) {
    const Cubic cubic = CubicOf(piece);
    const double v = cubic.from.speed_mm_s, a = cubic.acceleration, j = cubic.jerk;
    const double square = a * a - 2 * j * v;
    if (square < 0) continue;
    const double q = -(a + std::copysign(std::sqrt(square), a));
    // It turns back where v + a t + j t^2 / 2 = 0.
    for (const double t : {q / j, 2 * v / q}) {
      if (!(t > 0 && t < cubic.seconds)) continue;
      const double at_mm = step_.start_mm + cubic.At(t).gone_mm;
      if (at_mm < lo_mm - kRoundingMm || at_mm > hi_mm + kRoundingMm) return false;
    }
  }
  return true;
}

}  // namespace intaglio::motion
