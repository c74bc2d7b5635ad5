#include "engrave/sort/near/tick_cost.h"

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

// Ticks tried beyond the fewest. Steps from rest to rest take many ticks at high rates;
// in between, a tick more or less makes little difference.
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

}  // namespace

TickCost::TickCost(const motion::Limits& limits, double rate_hz)
    : rate_hz_(rate_hz),
      acceleration_mm_s2_(limits.max_acceleration_mm_s2.minCoeff()),
      many_choices_(rate_hz > kFewChoicesHz) {
  motion::RequireUsable(limits);
  Require(rate_hz > 0 && std::isfinite(rate_hz), "rate_hz must be positive, is {}",
          rate_hz);
  per_mm_ = rate_hz * rate_hz * limits.max_acceleration_mm_s2.cwiseInverse();
  const Vec3 per_speed =
      limits.max_acceleration_mm_s2.cwiseQuotient(limits.max_speed_mm_s) / rate_hz;
  per_speed_ = {static_cast<float>(per_speed.x()), static_cast<float>(per_speed.y()),
                static_cast<float>(per_speed.z())};
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

/// The choices for one step side by side, for the vector unit.
template <int kCount>
struct Choices {
  alignas(32) float ticks[kCount];
  alignas(32) float vx[kCount], vy[kCount], vz[kCount];  ///< step / ticks
  alignas(32) float cost[kCount];                        ///< of the way to here
  int from[kCount];

  void Set(const TimedMove& move, int choice) {
    const float per_tick = 1 / move.ticks;
    ticks[choice] = move.ticks;
    vx[choice] = move.step.x * per_tick;
    vy[choice] = move.step.y * per_tick;
    vz[choice] = move.step.z * per_tick;
  }
};

/// The cheapest way over `from` to choice `to` of the next step, less its own ticks.
template <int kCount>
float CheapestWay(const Choices<kCount>& from, const Choices<kCount>& next, int to,
                  int& chosen) {
  alignas(32) float cost[kCount];
  for (int i = 0; i < kCount; ++i) {
    const float dx = std::abs(next.vx[to] - from.vx[i]);
    const float dy = std::abs(next.vy[to] - from.vy[i]);
    const float dz = std::abs(next.vz[to] - from.vz[i]);
    const float xy = dx > dy ? dx : dy;
    const float bend = 2 * (xy > dz ? xy : dz) / (from.ticks[i] + next.ticks[to]);
    cost[i] = from.cost[i] + TickCost::BendCost(bend);
  }
  chosen = 0;
  for (int i = 1; i < kCount; ++i) {
    if (cost[i] < cost[chosen]) chosen = i;
  }
  return cost[chosen];
}

template <int kCount>
float ChooseTicks(const TickCost& tick_cost, const TimedMove& before,
                  std::span<const Scaled> steps, const TimedMove& after, float* ticks) {
  Choices<kCount> choices[TickCost::kMaxSteps + 2];
  for (int c = 0; c < kCount; ++c) {
    choices[0].Set(before, c);
    choices[0].cost[c] = 0;
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    Choices<kCount>& to = choices[i + 1];
    const float smallest = tick_cost.MinTicks(steps[i]);
    for (int c = 0; c < kCount; ++c) {
      to.Set({steps[i], smallest + kBeyond[c]}, c);
      to.cost[c] = to.ticks[c] + CheapestWay(choices[i], to, c, to.from[c]);
    }
  }
  Choices<kCount>& end = choices[steps.size() + 1];
  end.Set(after, 0);
  int chosen = 0;
  const float best = CheapestWay(choices[steps.size()], end, 0, chosen);
  for (std::size_t i = steps.size(); i-- > 0;) {
    ticks[i] = choices[i + 1].ticks[chosen];
    chosen = choices[i + 1].from[chosen];
  }
  return best;
}

}  // namespace

float TickCost::BestTicks(const TimedMove& before, std::span<const Scaled> steps,
                          const TimedMove& after, float* ticks) const {
  Require(!steps.empty() && steps.size() <= kMaxSteps, "{} steps at once", steps.size());
  return many_choices_ ? ChooseTicks<8>(*this, before, steps, after, ticks)
                       : ChooseTicks<4>(*this, before, steps, after, ticks);
}

float TickCost::CostOf(const TimedMove& before, std::span<const TimedMove> moves,
                       const TimedMove& after) {
  float cost = 0;
  const TimedMove* last = &before;
  for (const TimedMove& move : moves) {
    cost += move.ticks + BendCost(Bend(*last, move));
    last = &move;
  }
  return cost + BendCost(Bend(*last, after));
}

}  // namespace intaglio::sort
