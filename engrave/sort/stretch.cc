#include "engrave/sort/stretch.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kNear = 8;
constexpr std::size_t kLongestTurn = 512;
constexpr std::size_t kLongestPiece = 256;
constexpr std::size_t kFixed = 2;
constexpr int kDraws = 8;
constexpr std::uint64_t kCoolingSteps = 32;

std::vector<Scaled> ScaleAll(std::span<const Vec3> points_mm, const TickCost& cost) {
  std::vector<Scaled> scaled;
  scaled.reserve(points_mm.size());
  // Relative to one of them: floats are fine near zero.
  for (const Vec3& p : points_mm) scaled.push_back(cost.Scale(p - points_mm.front()));
  return scaled;
}

float TypicalStep(const std::vector<Scaled>& points) {
  std::vector<float> steps;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Scaled d = points[i] - points[i - 1];
    const float largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    if (largest > 0) steps.push_back(largest);
  }
  if (steps.empty()) return 1;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Points that can be neighbours of each other are near in height, too: the tolerance
/// counts as a typical step.
std::vector<Scaled> WithTubeHeights(const std::vector<Scaled>& points,
                                    const HeightTube& tube) {
  std::vector<Scaled> placed = points;
  if (tube.points_mm.empty()) return placed;
  Require(tube.points_mm.size() == points.size() && tube.axis_mm.size() == points.size(),
          "{} points have {} heights and {} places", points.size(), tube.points_mm.size(),
          tube.axis_mm.size());
  const double per_mm = TypicalStep(points) / tube.tolerance_mm;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    placed[i].z =
        static_cast<float>((tube.points_mm[i] - tube.points_mm.front()) * per_mm);
  }
  return placed;
}

}  // namespace

Stretch::Stretch(std::span<const Vec3> points_mm, const BeamCone& cone,
                 const TickCost& cost)
    : Stretch(points_mm, cone, cost, {}) {}

Stretch::Stretch(std::span<const Vec3> points_mm, const BeamCone& cone,
                 const TickCost& cost, const HeightTube& tube)
    : cost_(cost),
      points_(ScaleAll(points_mm, cost)),
      at_(points_mm.size()),
      place_(points_mm.size()),
      ticks_(points_mm.size(), 1),
      tube_(tube),
      precedence_(points_mm, cone),
      near_(WithTubeHeights(points_, tube), kNear, TypicalStep(points_)) {
  std::iota(at_.begin(), at_.end(), 0U);
  std::iota(place_.begin(), place_.end(), 0U);
  ChooseTicks();
}

void Stretch::Anneal(std::uint64_t tries, double hot, double cold, std::uint64_t seed) {
  Require(hot > 0 && cold > 0, "temperatures must be positive, are {} and {}", hot, cold);
  if (at_.size() <= 2 * kFixed + 1) return;
  generator_.seed(seed);
  double temperature = hot;
  const std::uint64_t tries_a_step = tries / kCoolingSteps + 1;
  for (std::uint64_t i = 0; i < tries; ++i) {
    if (i % tries_a_step == 0) {
      const double share = static_cast<double>(i) / static_cast<double>(tries);
      temperature = hot * std::pow(cold / hot, share);
    }
    Change change;
    if (!Propose(change) || !EndsStayInTube(change)) continue;
    const double chance = (static_cast<double>(generator_() >> 11) + 1) * 0x1p-53;
    const double bearable = -temperature * std::log(chance);
    if (-GainOf(change, bearable) > bearable || !IsAllowed(change)) continue;
    Apply(change);
  }
}

/// All ticks, a window at a time from the start on.
void Stretch::ChooseTicks() {
  if (at_.size() <= 2 * kFixed) return;
  TimedMove before{points_[at_[1]] - points_[at_[0]], 1};
  before.ticks = ticks_[1] = cost_.MinTicks(before.step);
  const std::size_t last = at_.size() - 1;
  ticks_[last] = cost_.MinTicks(MoveTo(last).step);
  // The second half of each window is chosen again with the next one.
  constexpr std::size_t kHalf = TickCost::kMaxSteps / 2;
  for (std::size_t first = kFixed; first < last; first += kHalf) {
    Scaled steps[TickCost::kMaxSteps];
    const std::size_t count = std::min(TickCost::kMaxSteps, last - first);
    for (std::size_t i = 0; i < count; ++i) steps[i] = MoveTo(first + i).step;
    TimedMove after = MoveTo(first + count);
    if (first + count < last) after.ticks = cost_.MinTicks(after.step);
    cost_.BestTicks(MoveTo(first - 1), {steps, count}, after, &ticks_[first]);
  }
}

std::size_t Stretch::PieceLength(std::size_t place, bool forwards) {
  const std::uint32_t kind = Below(4);
  if (kind < 2) return 1;
  if (kind == 2) return 1 + Below(3);
  // As far as the motion is smooth: up to the next step that takes longer.
  std::size_t length = 1;
  for (; length < kLongestPiece; ++length) {
    const std::size_t step = forwards ? place + length : place - length + 1;
    if (step <= kFixed || step >= at_.size() - kFixed || ticks_[step] > 1) break;
  }
  return length;
}

bool Stretch::Propose(Change& change) {
  std::size_t here = 0;
  for (int draws = 0; draws < kDraws; ++draws) {
    here = kFixed + Below(static_cast<std::uint32_t>(at_.size() - 2 * kFixed));
    if (ticks_[here] > 1 || ticks_[here + 1] > 1) break;
  }
  const auto near = near_.Of(at_[here]);
  if (near.empty()) return false;
  const std::size_t there = place_[near[Below(static_cast<std::uint32_t>(near.size()))]];
  const std::uint32_t kind = Below(5);
  if (kind == 0) {
    change = there > here ? Change{here + 1, there + 1, there + 1, true, false}
                          : Change{there, here, here, true, false};
    if (change.end < change.begin + 2 || change.end - change.begin > kLongestTurn) {
      return false;
    }
  } else {
    // A piece with `there` at one end comes next to `here`, behind or before it, turned
    // round where otherwise its other end would.
    const bool behind = kind <= 2;
    const bool turned = kind == 2 || kind == 4;
    const bool forwards = behind != turned;
    const std::size_t length = PieceLength(there, forwards);
    if (!forwards && length > there) return false;
    const std::size_t begin = forwards ? there : there + 1 - length;
    const std::size_t end = begin + length;
    if (begin <= here && here < end) return false;
    if (begin > here) {
      change = {behind ? here + 1 : here, begin, end, false, turned};
    } else {
      change = {begin, end, behind ? here + 1 : here, turned, false};
    }
    if (change.begin >= change.middle || change.middle >= change.end) return false;
  }
  return change.begin >= kFixed && change.end <= at_.size() - kFixed;
}

std::size_t Stretch::OldPlace(const Change& change, std::size_t place) const {
  if (place < change.begin || place >= change.end) return place;
  const std::size_t right = change.end - change.middle;
  std::size_t i = place - change.begin;
  if (i < right) return change.turn_right ? change.end - 1 - i : change.middle + i;
  i -= right;
  return change.turn_left ? change.middle - 1 - i : change.begin + i;
}

TimedMove Stretch::MoveTo(std::size_t place) const {
  return {points_[at_[place]] - points_[at_[place - 1]], ticks_[place]};
}

/// The move to a place once the change is made; where two pieces meet anew, its ticks
/// have no meaning yet.
TimedMove Stretch::MoveAfter(const Change& change, std::size_t place) const {
  const std::size_t from = OldPlace(change, place - 1);
  const std::size_t to = OldPlace(change, place);
  return {points_[at_[to]] - points_[at_[from]], ticks_[std::max(from, to)]};
}

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

/// How much cheaper the order is with the change. Both sides sum over the same steps but
/// those that go and come. Where even the fewest ticks of the new steps lose more than
/// `bearable`, no more than that is computed.
float Stretch::GainOf(const Change& change, double bearable) {
  float gain = 0;
  Window old[3];
  const std::size_t old_count =
      WindowsAround({change.begin, change.middle, change.end}, old);
  for (std::size_t w = 0; w < old_count; ++w) {
    TimedMove moves[TickCost::kMaxSteps];
    std::size_t count = 0;
    for (std::size_t i = old[w].first; i <= old[w].last; ++i) moves[count++] = MoveTo(i);
    gain += TickCost::CostOf(MoveTo(old[w].first - 1), {moves, count},
                             MoveTo(old[w].last + 1));
  }
  const std::size_t meet = change.begin + change.end - change.middle;
  new_window_count_ = WindowsAround({change.begin, meet, change.end}, new_windows_);
  Scaled steps[3][TickCost::kMaxSteps];
  float greatest = gain;
  for (std::size_t w = 0; w < new_window_count_; ++w) {
    std::size_t count = 0;
    for (std::size_t i = new_windows_[w].first; i <= new_windows_[w].last; ++i) {
      steps[w][count] = MoveAfter(change, i).step;
      greatest -= cost_.MinTicks(steps[w][count++]);
    }
  }
  if (-greatest > bearable) return greatest;
  for (std::size_t w = 0; w < new_window_count_; ++w) {
    Window& window = new_windows_[w];
    gain -= cost_.BestTicks(MoveAfter(change, window.first - 1),
                            {steps[w], window.last - window.first + 1},
                            MoveAfter(change, window.last + 1), window.ticks);
  }
  return gain;
}

/// Whether no point of a piece must precede another one of it.
bool Stretch::CanTurn(std::size_t begin, std::size_t end) const {
  for (std::size_t i = begin; i < end; ++i) {
    for (const std::uint32_t after : precedence_.After(at_[i])) {
      if (place_[after] < end) return false;
    }
  }
  return true;
}

/// Whether the point that comes to this place is within the tolerance of the axis there.
bool Stretch::StaysInTubeAt(const Change& change, std::size_t place) const {
  const double height_mm = tube_.points_mm[at_[OldPlace(change, place)]];
  return std::abs(height_mm - tube_.axis_mm[place]) <= tube_.tolerance_mm;
}

/// Whether each point that moves does.
bool Stretch::StaysInTube(const Change& change) const {
  if (tube_.points_mm.empty()) return true;
  for (std::size_t place = change.begin; place < change.end; ++place) {
    if (!StaysInTubeAt(change, place)) return false;
  }
  return true;
}

/// Most changes that leave the tube do so here, which costs less than their gain.
bool Stretch::EndsStayInTube(const Change& change) const {
  if (tube_.points_mm.empty()) return true;
  const std::size_t meet = change.begin + change.end - change.middle;
  const auto stays = [&](std::size_t place) { return StaysInTubeAt(change, place); };
  return stays(change.begin) && stays(change.end - 1) && stays(meet - 1) &&
         stays(std::min(meet, change.end - 1));
}

bool Stretch::IsAllowed(const Change& change) const {
  const auto [begin, middle, end, turn_left, turn_right] = change;
  if (!StaysInTube(change)) return false;
  if (turn_left && !CanTurn(begin, middle)) return false;
  if (turn_right && !CanTurn(middle, end)) return false;
  // No point of the left piece may have to precede one of the right piece.
  if (middle - begin <= end - middle) {
    for (std::size_t i = begin; i < middle; ++i) {
      for (const std::uint32_t after : precedence_.After(at_[i])) {
        if (place_[after] >= middle && place_[after] < end) return false;
      }
    }
    return true;
  }
  for (std::size_t i = middle; i < end; ++i) {
    for (const std::uint32_t before : precedence_.Before(at_[i])) {
      if (place_[before] >= begin && place_[before] < middle) return false;
    }
  }
  return true;
}

void Stretch::Apply(const Change& change) {
  moved_.clear();
  moved_ticks_.clear();
  for (std::size_t i = change.begin; i < change.end; ++i) {
    moved_.push_back(at_[OldPlace(change, i)]);
    moved_ticks_.push_back(MoveAfter(change, i).ticks);
  }
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    at_[change.begin + i] = moved_[i];
    place_[moved_[i]] = static_cast<std::uint32_t>(change.begin + i);
    ticks_[change.begin + i] = moved_ticks_[i];
  }
  for (std::size_t w = 0; w < new_window_count_; ++w) {
    const Window& window = new_windows_[w];
    std::copy_n(window.ticks, window.last - window.first + 1,
                ticks_.begin() + static_cast<std::ptrdiff_t>(window.first));
  }
}

}  // namespace intaglio::sort
