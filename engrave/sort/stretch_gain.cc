#include <algorithm>
#include <limits>

#include "engrave/sort/stretch.h"

// What a change of a stretch gains. Old and new cost are sums over the windows around the
// places where pieces part and meet; the steps between them stay as they are.

namespace intaglio::sort {
namespace {

constexpr float kNone = -std::numeric_limits<float>::infinity();
/// Behind so many steps a way hardly ever depends on how it began.
constexpr std::size_t kMemory = 6;

}  // namespace

/// Each step with one more on both sides, joined where they touch.
std::size_t Stretch::WindowsAround(const std::size_t (&steps)[3],
                                   Window (&windows)[3]) const {
  std::size_t count = 0;
  for (const std::size_t step : steps) {
    const std::size_t first = std::max(step - 1, kFixed);
    const std::size_t last = std::min(step + 1, at_.size() - kFixed);
    if (count > 0 && first <= windows[count - 1].last + 1) {
      windows[count - 1].last = std::max(windows[count - 1].last, last);
    } else {
      windows[count].first = first;
      windows[count].last = last;
      ++count;
    }
  }
  return count;
}

/// The fewest ticks of the steps where pieces meet anew, less those of the steps that go.
float Stretch::NewMinTicks(const Change& change) const {
  const auto [begin, middle, end, turn_left, turn_right] = change;
  const Scaled left[] = {places_[begin].point, places_[middle - 1].point};
  const Scaled& before = places_[begin - 1].point;
  const Scaled& after = places_[end].point;
  const float gone = places_[begin].min_ticks + places_[end].min_ticks;
  if (middle == end) {
    return cost_.MinTicks(left[turn_left ? 1 : 0] - before) +
           cost_.MinTicks(after - left[turn_left ? 0 : 1]) - gone;
  }
  const Scaled right[] = {places_[middle].point, places_[end - 1].point};
  return cost_.MinTicks(right[turn_right ? 1 : 0] - before) +
         cost_.MinTicks(left[turn_left ? 1 : 0] - right[turn_right ? 0 : 1]) +
         cost_.MinTicks(after - left[turn_left ? 0 : 1]) - gone -
         places_[middle].min_ticks;
}

/// How much cheaper the order can at best be with the change. Both sides sum over the
/// same steps but those that go and come. Where even the fewest ticks of the new steps
/// lose more than `bearable`, no more than that is computed.
float Stretch::MaxGain(const Change& change, double bearable) {
  Window old[3];
  const std::size_t old_count =
      WindowsAround({change.begin, change.middle, change.end}, old);
  float spare = -NewMinTicks(change);
  old_cost_ = 0;
  for (std::size_t w = 0; w < old_count; ++w) {
    for (std::size_t i = old[w].first; i <= old[w].last; ++i) {
      const Place& place = places_[i];
      old_cost_ += place.ticks + place.bend_cost;
      spare += place.ticks - place.min_ticks + place.bend_cost;
    }
    const float bend_behind = places_[old[w].last + 1].bend_cost;
    old_cost_ += bend_behind;
    spare += bend_behind;
  }
  // What the new steps may cost beyond their fewest ticks. Sums of floats are rounded.
  constexpr float kRounded = 1e-3F;
  const float left = spare + static_cast<float>(bearable) + kRounded;
  if (left < 0) return spare;
  const std::size_t meet = change.begin + change.end - change.middle;
  new_window_count_ = WindowsAround({change.begin, meet, change.end}, new_windows_);
  float gain = old_cost_;
  for (std::size_t w = 0; w < new_window_count_; ++w) {
    Window& window = new_windows_[w];
    Scaled steps[TickCost::kMaxSteps];
    std::size_t count = 0;
    for (std::size_t i = window.first; i <= window.last; ++i)
      steps[count++] = MoveAfter(change, i).step;
    gain -= cost_.BestTicks(MoveAfter(change, window.first - 1), {steps, count},
                            MoveAfter(change, window.last + 1), window.ticks, left);
    if (gain == -std::numeric_limits<float>::infinity()) return gain;
  }
  return gain;
}

/// How much cheaper the order is with the change, whose MaxGain was computed last, in
/// ticks that the axes can keep: they are in the windows then. kNone where it costs more
/// than `bearable`.
float Stretch::Gain(const Change& change, double bearable) {
  const float limit = old_cost_ + static_cast<float>(bearable);
  Ways ways;
  const std::size_t first = new_windows_[0].first;
  ways.all[0] = {speeds_.Past(first - 1), MoveAfter(change, first - 1), 0, {}, 0};
  ways.count = 1;
  std::size_t behind = first;
  for (std::size_t w = 0; w < new_window_count_; ++w) {
    const Window& window = new_windows_[w];
    if (w > 0) PassPiece(change, behind, window.first - 1, limit, ways);
    for (std::size_t i = window.first; i <= window.last && ways.count > 0; ++i)
      PassStep(MoveAfter(change, i).step, limit, ways);
    behind = window.last + 1;
  }
  const Way* best = CheapestInto(MoveAfter(change, behind), behind - 1, limit, ways);
  if (best == nullptr) return kNone;
  const float* ticks = best->ticks;
  for (std::size_t w = 0; w < new_window_count_; ++w) {
    Window& window = new_windows_[w];
    for (std::size_t i = window.first; i <= window.last; ++i)
      window.ticks[i - window.first] = *ticks++;
  }
  return old_cost_ - best->cost;
}

/// Goes on by one step, in each number of ticks that is cheap enough.
void Stretch::PassStep(const Scaled& step, float limit, Ways& ways) const {
  const float smallest = cost_.MinTicks(step);
  Ways next;
  for (std::size_t k = 0; k < ways.count; ++k) {
    const Way& from = ways.all[k];
    for (const float beyond : cost_.Beyond()) {
      Way to;
      to.last = {step, smallest + beyond};
      to.cost =
          from.cost + to.last.ticks + cost_.BendCost(TickCost::Bend(from.last, to.last));
      if (to.cost > limit || next.IsFullAt(to.cost)) continue;
      if (!speeds_.Pass(from.speeds, to.last, to.speeds)) continue;
      std::copy_n(from.ticks, from.count, to.ticks);
      to.count = from.count;
      to.ticks[to.count++] = to.last.ticks;
      next.Keep(to);
    }
  }
  ways = next;
}

/// Goes on through a piece, to the places [first, last] with the change made, whose steps
/// keep their ticks. Deep in it the speeds are those of before.
void Stretch::PassPiece(const Change& change, std::size_t first, std::size_t last,
                        float limit, Ways& ways) const {
  const bool is_right = first < change.begin + change.end - change.middle;
  const bool is_turned = is_right ? change.turn_right : change.turn_left;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < ways.count; ++k) {
    Way way = ways.all[k];
    way.cost += cost_.BendCost(TickCost::Bend(way.last, MoveAfter(change, first)));
    bool passes = way.cost <= limit;
    for (std::size_t i = first; passes && i <= last; ++i) {
      if (i == first + kMemory && last > i + kMemory) {
        i = last - kMemory;
        const std::size_t place = OldPlace(change, i);
        way.speeds = is_turned ? speeds_.Future(place).Reversed() : speeds_.Past(place);
        continue;
      }
      passes = speeds_.Pass(way.speeds, MoveAfter(change, i), way.speeds);
    }
    if (!passes) continue;
    way.last = MoveAfter(change, last);
    ways.all[kept++] = way;
  }
  ways.count = kept;
}

/// The cheapest way at `place` that goes on with what follows there; null: none is within
/// the limit. Its cost then has the last bend, too.
const Stretch::Way* Stretch::CheapestInto(const TimedMove& after, std::size_t place,
                                          float limit, Ways& ways) const {
  const Way* best = nullptr;
  for (std::size_t k = 0; k < ways.count; ++k) {
    Way& way = ways.all[k];
    way.cost += cost_.BendCost(TickCost::Bend(way.last, after));
    if (way.cost > limit || (best != nullptr && best->cost <= way.cost)) continue;
    if (way.speeds.Meets(speeds_.Future(place))) best = &way;
  }
  return best;
}

/// Whether ways of that cost have no place any more.
bool Stretch::Ways::IsFullAt(float cost) const {
  return count == kMaxWays && all[count - 1].cost <= cost;
}

/// Keeps the cheapest.
void Stretch::Ways::Keep(const Way& way) {
  std::size_t at = count == kMaxWays ? count - 1 : count++;
  for (; at > 0 && all[at - 1].cost > way.cost; --at) all[at] = all[at - 1];
  all[at] = way;
}

}  // namespace intaglio::sort
