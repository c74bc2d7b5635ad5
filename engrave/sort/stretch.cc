#include "engrave/sort/stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engrave/core/check.h"
#include "engrave/motion/tick_planner.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kNear = 8;
constexpr std::size_t kLongestTurn = 512;
constexpr std::size_t kLongestPiece = 256;
/// Slow places are searched for anew after this many tries.
constexpr std::uint64_t kTriesASearch = 1024;
/// One in this many tries begins at any place: some changes pay only where no step is
/// slow.
constexpr std::uint32_t kTriesAnywhere = 8;
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
    : Stretch(ScaleAll(points_mm, cost), points_mm, cone, cost, tube) {}

Stretch::Stretch(const std::vector<Scaled>& points, std::span<const Vec3> points_mm,
                 const BeamCone& cone, const TickCost& cost, const HeightTube& tube)
    : cost_(cost),
      speeds_(cost),
      places_(points.size()),
      at_(points.size()),
      place_(points.size()),
      has_tube_(!tube.points_mm.empty()),
      tolerance_mm_(static_cast<float>(tube.tolerance_mm)),
      precedence_(points_mm, cone),
      typical_step_(TypicalStep(points)),
      near_(WithTubeHeights(points, tube), kNear, typical_step_) {
  std::iota(at_.begin(), at_.end(), 0U);
  std::iota(place_.begin(), place_.end(), 0U);
  for (std::size_t i = 0; i < points.size(); ++i) places_[i] = {points[i], 0, 1, 1, 0};
  if (has_tube_) {
    const double from_mm = tube.points_mm.front();
    for (std::size_t i = 0; i < points.size(); ++i) {
      places_[i].height_mm = static_cast<float>(tube.points_mm[i] - from_mm);
      axis_mm_.push_back(static_cast<float>(tube.axis_mm[i] - from_mm));
    }
  }
  ChooseTicks();
}

void Stretch::Anneal(std::uint64_t tries, double hot, double cold, std::uint64_t seed) {
  Require(hot > 0 && cold > 0, "temperatures must be positive, are {} and {}", hot, cold);
  if (at_.size() <= 2 * kFixed + 1) return;
  random_.Seed(seed);
  double temperature = hot;
  const std::uint64_t tries_a_step = tries / kCoolingSteps + 1;
  for (std::uint64_t i = 0; i < tries; ++i) {
    if (i % tries_a_step == 0) {
      const double share = static_cast<double>(i) / static_cast<double>(tries);
      temperature = hot * std::pow(cold / hot, share);
    }
    if (i % kTriesASearch == 0) FindSlow();
    Change change;
    if (!Propose(near_, change) || !EndsStayInTube(change)) continue;
    const double chance = (static_cast<double>(random_() >> 11) + 1) * 0x1p-53;
    const double bearable = -temperature * std::log(chance);
    if (BearableGain(change, bearable)) Apply(change);
  }
}

/// How much cheaper the order is with an allowed change; nullopt: it is not allowed, or
/// costs more than is bearable. Apply takes the ticks that were computed last.
std::optional<float> Stretch::BearableGain(const Change& change, double bearable) {
  float gain = MaxGain(change, bearable);
  if (-gain > bearable || !IsAllowed(change)) return std::nullopt;
  if (cost_.fit() == Fit::kWay) gain = Gain(change, bearable);
  if (-gain > bearable) return std::nullopt;
  return gain;
}

void Stretch::ChooseTicks() {
  if (at_.size() <= 2 * kFixed) return;
  for (std::size_t i = 1; i < at_.size(); ++i) SetStepTo(i);
  if (cost_.fit() == Fit::kWay) {
    ChooseTicksOfWay();
  } else {
    ChooseTicksOfNeighbours();
  }
  SetBends(kFixed, at_.size() - 1);
}

/// The fewest with which the axes can make the way, from rest to rest.
void Stretch::ChooseTicksOfWay() {
  motion::Limits limits;
  limits.max_speed_mm_s = cost_.TopSpeeds();
  limits.max_acceleration_mm_s2 = Vec3::Constant(1);
  motion::TickLabels labels(motion::StepLimitsOf(limits, 1), 1, 1,
                            motion::OptionsForRate(cost_.rate_hz()).labels);
  PointList steps;
  for (std::size_t i = 1; i < at_.size(); ++i) {
    const Scaled step = MoveTo(i).step;
    steps.emplace_back(step.x, step.y, step.z);
  }
  std::vector<motion::TimedStep> timed;
  labels.Choose({}, steps, false, {}, timed);
  for (std::size_t i = 1; i < at_.size(); ++i)
    places_[i].ticks = static_cast<float>(timed[i - 1].ticks);
  const auto move_to = [this](std::size_t place) { return MoveTo(place); };
  Require(speeds_.Begin(at_.size(), move_to), "{} steps cannot be made", steps.size());
}

/// A window at a time from the start on.
void Stretch::ChooseTicksOfNeighbours() {
  const std::size_t last = at_.size() - 1;
  places_[1].ticks = places_[1].min_ticks;
  places_[last].ticks = places_[last].min_ticks;
  // The second half of each window is chosen again with the next one.
  constexpr std::size_t kHalf = TickCost::kMaxSteps / 2;
  for (std::size_t first = kFixed; first < last; first += kHalf) {
    Scaled steps[TickCost::kMaxSteps];
    float ticks[TickCost::kMaxSteps];
    const std::size_t count = std::min(TickCost::kMaxSteps, last - first);
    for (std::size_t i = 0; i < count; ++i) steps[i] = MoveTo(first + i).step;
    TimedMove after = MoveTo(first + count);
    if (first + count < last) after.ticks = places_[first + count].min_ticks;
    cost_.BestTicks(MoveTo(first - 1), {steps, count}, after, ticks);
    for (std::size_t i = 0; i < count; ++i) places_[first + i].ticks = ticks[i];
  }
}

void Stretch::SetStepTo(std::size_t place) {
  places_[place].min_ticks = cost_.MinTicks(MoveTo(place).step);
}

/// Of the steps to these places, both included.
void Stretch::SetBends(std::size_t first, std::size_t last) {
  for (std::size_t i = first; i <= last; ++i)
    places_[i].bend_cost = cost_.BendCost(TickCost::Bend(MoveTo(i - 1), MoveTo(i)));
}

std::size_t Stretch::PieceLength(std::size_t place, bool forwards) {
  const std::uint32_t kind = Below(4);
  if (kind < 2) return 1;
  if (kind == 2) return 1 + Below(3);
  return SmoothLength(place, forwards, kLongestPiece);
}

/// As far as the motion is smooth: up to the next step that takes longer.
std::size_t Stretch::SmoothLength(std::size_t place, bool forwards,
                                  std::size_t longest) const {
  std::size_t length = 1;
  for (; length < longest && (forwards || length <= place); ++length) {
    const std::size_t step = forwards ? place + length : place - length + 1;
    if (step <= kFixed || step >= at_.size() - kFixed || places_[step].ticks > 1) break;
  }
  return length;
}

void Stretch::FindSlow() {
  slow_.clear();
  for (std::size_t i = kFixed; i < at_.size() - kFixed; ++i) {
    if (places_[i].ticks > 1 || places_[i + 1].ticks > 1)
      slow_.push_back(static_cast<std::uint32_t>(i));
  }
}

/// Where ticks can be saved, mostly: in a good order few steps are slow.
std::size_t Stretch::PlaceToImprove() {
  if (slow_.empty() || Below(kTriesAnywhere) == 0)
    return kFixed + Below(static_cast<std::uint32_t>(at_.size() - 2 * kFixed));
  return slow_[Below(static_cast<std::uint32_t>(slow_.size()))];
}

bool Stretch::Propose(const NearPoints& all_near, Change& change) {
  const std::size_t here = PlaceToImprove();
  const auto near = all_near.Of(at_[here]);
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
  return {places_[place].point - places_[place - 1].point, places_[place].ticks};
}

/// The move to a place once the change is made; where two pieces meet anew, its ticks
/// have no meaning yet.
TimedMove Stretch::MoveAfter(const Change& change, std::size_t place) const {
  const std::size_t from = OldPlace(change, place - 1);
  const std::size_t to = OldPlace(change, place);
  return {places_[to].point - places_[from].point, places_[std::max(from, to)].ticks};
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
  const float height_mm = places_[OldPlace(change, place)].height_mm;
  return std::abs(height_mm - axis_mm_[place]) <= tolerance_mm_;
}

/// Whether each point that moves does.
bool Stretch::StaysInTube(const Change& change) const {
  if (!has_tube_) return true;
  const auto [begin, middle, end, turn_left, turn_right] = change;
  return PieceStaysInTube(middle, end, turn_right, begin) &&
         PieceStaysInTube(begin, middle, turn_left, begin + end - middle);
}

/// The same of the places [begin, end), moved to `to` and turned round or not.
bool Stretch::PieceStaysInTube(std::size_t begin, std::size_t end, bool turned,
                               std::size_t to) const {
  for (std::size_t i = 0; i < end - begin; ++i) {
    const float height_mm = places_[turned ? end - 1 - i : begin + i].height_mm;
    if (!(std::abs(height_mm - axis_mm_[to + i]) <= tolerance_mm_)) return false;
  }
  return true;
}

/// Most changes that leave the tube do so here, which costs less than their gain.
bool Stretch::EndsStayInTube(const Change& change) const {
  if (!has_tube_) return true;
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
  const std::size_t meet = change.begin + change.end - change.middle;
  moved_.clear();
  moved_places_.clear();
  for (std::size_t i = change.begin; i < change.end; ++i) {
    const std::size_t old = OldPlace(change, i);
    moved_.push_back(at_[old]);
    Place& place = moved_places_.emplace_back(places_[old]);
    if (!(i < meet ? change.turn_right : change.turn_left)) continue;
    // The other way round the step to it is the one that left it.
    place.ticks = places_[old + 1].ticks;
    place.min_ticks = places_[old + 1].min_ticks;
    place.bend_cost = places_[old + 2].bend_cost;
  }
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    at_[change.begin + i] = moved_[i];
    place_[moved_[i]] = static_cast<std::uint32_t>(change.begin + i);
    places_[change.begin + i] = moved_places_[i];
  }
  for (const std::size_t joint : {change.begin, meet, change.end}) SetStepTo(joint);
  for (std::size_t w = 0; w < new_window_count_; ++w) {
    const Window& window = new_windows_[w];
    for (std::size_t i = window.first; i <= window.last; ++i)
      places_[i].ticks = window.ticks[i - window.first];
  }
  for (std::size_t w = 0; w < new_window_count_; ++w)
    SetBends(new_windows_[w].first, new_windows_[w].last + 1);
  if (cost_.fit() == Fit::kWay) ApplyToSpeeds(change);
}

/// The change is made already.
void Stretch::ApplyToSpeeds(const Change& change) {
  const std::size_t meet = change.begin + change.end - change.middle;
  speeds_.Rearrange(
      change.begin, change.end,
      [&](std::size_t place) { return OldPlace(change, place); },
      [&](std::size_t place) {
        return place < meet ? change.turn_right : change.turn_left;
      });
  WaySpeeds::Steps changed[3];
  for (std::size_t w = 0; w < new_window_count_; ++w)
    changed[w] = {new_windows_[w].first, new_windows_[w].last};
  const auto move_to = [this](std::size_t place) { return MoveTo(place); };
  // Once in 100 000 changes a piece depends on what was before it longer than Gain has
  // followed it.
  if (!speeds_.Settle({changed, new_window_count_}, move_to)) ChooseTicks();
}

}  // namespace intaglio::sort
