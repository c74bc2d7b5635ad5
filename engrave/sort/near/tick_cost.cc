#include "engrave/sort/near/tick_cost.h"

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

/// By trial. Where steps only fit their neighbours, the planner needs a reserve: at a
/// jerk of 2000 m/s^3 a weight of 0.3 leaves 0.92 points a tick, and 0.7 leaves 0.97.
float BendWeightOf(Fit fit) { return fit == Fit::kWay ? 0.3F : 0.7F; }

constexpr float kBeyond[] = {0, 1, 2, 3, 4, 7, 12, 19};

/// Relative, of ticks that are whole but for rounding.
constexpr double kRounding = 1e-7;

double RoundUp(double ticks) { return std::ceil(ticks * (1 - kRounding)); }

/// Enough ticks for an axis: from `fewest` on, but not between the ends of the gap.
struct AxisTicks {
  double fewest = 0;
  double gap_begin = 0;
  double gap_end = 0;
};

// After d1 in m ticks, v = d1 / m, and for d >= 0 (else both are mirrored), the limit
// 2 |d / n - v| <= n + m is the two
//   n^2 + (m + 2 v) n - 2 d >= 0:  n not below its one root >= 0;
//   n^2 + (m - 2 v) n + 2 d >= 0:  n not between its roots: too slow to keep the speed,
//                                  too fast to lose it.
AxisTicks TicksOfAxis(double before, double before_ticks, double step) {
  const double sign = step < 0 ? -1 : 1;
  const double d = sign * step;
  const double v = sign * before / before_ticks;
  const double rise = 0.5 * before_ticks + v;
  const double root = std::sqrt(rise * rise + 2 * d);
  AxisTicks ticks;
  ticks.fewest = rise > 0 ? 2 * d / (rise + root) : root - rise;
  const double fall = v - 0.5 * before_ticks;
  const double square = fall * fall - 2 * d;
  if (fall <= 0 || square <= 0) return ticks;
  ticks.gap_end = fall + std::sqrt(square);
  ticks.gap_begin = 2 * d / ticks.gap_end;
  return ticks;
}

/// At and below it four choices are enough, by trial.
constexpr double kFewChoicesHz = 250;
constexpr int kMaxChoices = 8;

}  // namespace

TickCost::TickCost(const motion::Limits& limits, double rate_hz, Fit fit)
    : rate_hz_(rate_hz),
      acceleration_mm_s2_(limits.max_acceleration_mm_s2.minCoeff()),
      many_choices_(rate_hz > kFewChoicesHz),
      fit_(fit),
      bend_weight_(BendWeightOf(fit)) {
  motion::RequireUsable(limits);
  Require(rate_hz > 0 && std::isfinite(rate_hz), "rate_hz must be positive, is {}",
          rate_hz);
  per_mm_ = rate_hz * rate_hz * limits.max_acceleration_mm_s2.cwiseInverse();
  const Vec3 per_speed =
      limits.max_acceleration_mm_s2.cwiseQuotient(limits.max_speed_mm_s) / rate_hz;
  per_speed_ = {static_cast<float>(per_speed.x()), static_cast<float>(per_speed.y()),
                static_cast<float>(per_speed.z())};
}

std::span<const float> TickCost::Beyond() const {
  return std::span(kBeyond).first(many_choices_ ? kMaxChoices : kMaxChoices / 2);
}

float TickCost::TicksAfter(const TimedMove& before, const Scaled& step) const {
  const float smallest = MinTicks(step);
  if (Bend(before, {step, smallest}) <= 1) return smallest;
  const AxisTicks axes[] = {TicksOfAxis(before.step.x, before.ticks, step.x),
                            TicksOfAxis(before.step.y, before.ticks, step.y),
                            TicksOfAxis(before.step.z, before.ticks, step.z)};
  double ticks = smallest;
  for (const AxisTicks& axis : axes) ticks = std::max(ticks, RoundUp(axis.fewest));
  // The end of one gap may be inside the gap of an axis checked before; the ticks never
  // decrease.
  for (int round = 0; round < 3; ++round) {
    for (const AxisTicks& axis : axes) {
      if (ticks > axis.gap_begin * (1 + kRounding)) {
        ticks = std::max(ticks, RoundUp(axis.gap_end));
      }
    }
  }
  return static_cast<float>(ticks);
}

double TickCost::StopAndGoTicks(double mm) const {
  return 2 * std::sqrt(mm / acceleration_mm_s2_) * rate_hz_;
}

namespace {

/// What one choice of ticks makes of a step. Without initial values: of hundreds few are
/// used.
struct Choice {
  float ticks;
  float vx, vy, vz;  ///< step / ticks
  float cost;        ///< of the way to here
  int from;          ///< the choice of the step before

  void Set(const Scaled& step, float in_ticks) {
    const float per_tick = 1 / in_ticks;
    ticks = in_ticks;
    vx = step.x * per_tick;
    vy = step.y * per_tick;
    vz = step.z * per_tick;
  }
};

struct Choices {
  Choice all[kMaxChoices];
  int count;
};

/// Sets the cost of `to` to that of the cheapest way over `from`, its own ticks included.
void GoCheapest(const TickCost& cost_of, const Choices& from, float own_ticks,
                Choice& to) {
  to.cost = std::numeric_limits<float>::infinity();
  for (int i = 0; i < from.count; ++i) {
    const Choice& before = from.all[i];
    const float largest =
        std::max({std::abs(to.vx - before.vx), std::abs(to.vy - before.vy),
                  std::abs(to.vz - before.vz)});
    const float bend = 2 * largest / (before.ticks + to.ticks);
    const float cost = before.cost + cost_of.BendCost(bend);
    if (cost < to.cost) to.cost = cost, to.from = i;
  }
  to.cost += own_ticks;
}

}  // namespace

// A step with more than the fewest ticks makes the sum so much larger at least: choices
// beyond the spare need no trial, nor does what follows a way that has used it up.
float TickCost::BestTicks(const TimedMove& before, std::span<const Scaled> steps,
                          const TimedMove& after, float* ticks, float spare) const {
  Require(!steps.empty() && steps.size() <= kMaxSteps, "{} steps at once", steps.size());
  const auto max_count = static_cast<int>(Beyond().size());
  int count = 1;
  while (count < max_count && kBeyond[count] <= spare) ++count;
  Choices choices[kMaxSteps + 2];
  choices[0].all[0].Set(before.step, before.ticks);
  choices[0].all[0].cost = 0;
  choices[0].count = 1;
  float fewest = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    Choices& to = choices[i + 1];
    const float smallest = MinTicks(steps[i]);
    fewest += smallest;
    float cheapest = std::numeric_limits<float>::infinity();
    to.count = count;
    for (int c = 0; c < count; ++c) {
      Choice& choice = to.all[c];
      choice.Set(steps[i], smallest + kBeyond[c]);
      GoCheapest(*this, choices[i], choice.ticks, choice);
      cheapest = std::min(cheapest, choice.cost);
    }
    if (cheapest > fewest + spare) return std::numeric_limits<float>::infinity();
  }
  Choice end;
  end.Set(after.step, after.ticks);
  GoCheapest(*this, choices[steps.size()], 0, end);
  int chosen = end.from;
  for (std::size_t i = steps.size(); i-- > 0;) {
    ticks[i] = choices[i + 1].all[chosen].ticks;
    chosen = choices[i + 1].all[chosen].from;
  }
  return end.cost;
}

float TickCost::CostOf(const TimedMove& before, std::span<const TimedMove> moves,
                       const TimedMove& after) const {
  float cost = 0;
  const TimedMove* last = &before;
  for (const TimedMove& move : moves) {
    cost += move.ticks + BendCost(Bend(*last, move));
    last = &move;
  }
  return cost + BendCost(Bend(*last, after));
}

}  // namespace intaglio::sort
