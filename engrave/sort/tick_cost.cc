#include "engrave/sort/tick_cost.h"

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

// Ticks tried beyond the fewest. Steps from rest to rest take many ticks at high rates;
// in between, a tick more or less makes little difference.
constexpr float kBeyond[] = {0, 1, 2, 3, 4, 7, 12, 19};

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
  float ticks = LeastTicks(step);
  // Twice as long at a time, then back: a step across the block takes thousands.
  float too_few = ticks - 1;
  while (Bend(before, {step, ticks}) > 1) {
    too_few = ticks;
    ticks = std::ceil(ticks * 1.5F);
  }
  while (ticks - too_few > 1) {
    const float middle = std::floor(0.5F * (ticks + too_few));
    (Bend(before, {step, middle}) > 1 ? too_few : ticks) = middle;
  }
  return ticks;
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
  Choices<kCount> choices[TickCost::kMostSteps + 2];
  for (int c = 0; c < kCount; ++c) {
    choices[0].Set(before, c);
    choices[0].cost[c] = 0;
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    Choices<kCount>& to = choices[i + 1];
    const float least = tick_cost.LeastTicks(steps[i]);
    for (int c = 0; c < kCount; ++c) {
      to.Set({steps[i], least + kBeyond[c]}, c);
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
  Require(!steps.empty() && steps.size() <= kMostSteps, "{} steps at once", steps.size());
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
