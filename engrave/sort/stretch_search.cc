#include "engrave/sort/stretch_search.h"

#include <algorithm>
#include <cmath>

namespace intaglio::sort {
namespace {

// All by trial.
/// Points that are asked for their ticks, and of them the first ones that are tried.
constexpr std::size_t kNear = 24, kNearInTicks = 3;
/// Points near to a place where the order closes again.
constexpr std::size_t kNearJoints = 3;
constexpr std::size_t kLongestTurn = 512;
constexpr std::size_t kLongestRun = 256;
/// The shorter of two pieces that change places has no more points.
constexpr std::size_t kLongestPiece = 50;
/// In ticks; less is no gain, as sums of floats are rounded.
constexpr float kMinGain = 0.01F;
/// By how many ticks the first new step must cost less than the one that goes.
constexpr float kFirstGain = 0.5F;
/// What a kick may lose, in ticks, and how often one is sought in a row.
constexpr double kKick = 2;
constexpr int kKickTries = 64;
constexpr double kNoLoss = 1e-6;
constexpr std::uint64_t kKicksASearch = 512;

}  // namespace

StretchSearch::StretchSearch(Stretch& stretch)
    : stretch_(stretch),
      near_(PointsOf(stretch), kNear, stretch.typical_step_),
      waits_(stretch.at_.size()) {}

std::vector<Scaled> StretchSearch::PointsOf(const Stretch& stretch) {
  std::vector<Scaled> points;
  points.reserve(stretch.at_.size());
  for (const std::uint32_t place : stretch.place_)
    points.push_back(stretch.places_[place].point);
  return points;
}

void StretchSearch::Run(std::uint64_t tries, std::uint64_t seed) {
  Stretch& s = stretch_;
  if (s.at_.size() <= 2 * Stretch::kFixed + 1) return;
  s.random_.Seed(seed);
  tries_left_ = tries;
  records_ = false;
  for (std::size_t i = 1; i + 1 < s.at_.size(); ++i) Wait(i);
  SearchQueue();
  Empty();
  records_ = true;
  for (std::uint64_t kick = 0; tries_left_ > 0; ++kick) {
    if (kick % kKicksASearch == 0) s.FindSlow();
    cost_ = 0;
    made_.clear();
    if (!Kick()) continue;
    SearchQueue();
    Empty();
    if (cost_ > kNoLoss) Undo();
  }
}

/// A change of seen places as one of places.
StretchSearch::Change StretchSearch::Seen(const Change& change) const {
  if (!backwards_) return change;
  const std::size_t size = stretch_.at_.size();
  if (change.middle == change.end)
    return {size - change.end, size - change.begin, size - change.begin, true, false};
  return {size - change.end, size - change.middle, size - change.begin, change.turn_right,
          change.turn_left};
}

void StretchSearch::Wait(std::size_t place) {
  if (place >= stretch_.at_.size()) return;
  const std::uint32_t point = stretch_.at_[place];
  if (waits_[point]) return;
  waits_[point] = true;
  queue_.push_back(point);
}

void StretchSearch::Empty() {
  for (; queue_begin_ < queue_.size(); ++queue_begin_)
    waits_[queue_[queue_begin_]] = false;
  queue_.clear();
  queue_begin_ = 0;
}

void StretchSearch::SearchQueue() {
  while (queue_begin_ < queue_.size() && tries_left_ > 0) {
    const std::uint32_t point = queue_[queue_begin_++];
    waits_[point] = false;
    if (Improve(point)) Wait(stretch_.place_[point]);
  }
}

bool StretchSearch::Improve(std::uint32_t point) {
  for (const bool backwards : {false, true}) {
    backwards_ = backwards;
    if (ReplaceStepBehind(point)) return true;
  }
  return false;
}

bool StretchSearch::ReplaceStepBehind(std::uint32_t point) {
  const Stretch& s = stretch_;
  const std::size_t place = s.place_[point];
  const std::size_t end = s.at_.size() - Stretch::kFixed;
  const std::size_t gone = backwards_ ? place : place + 1;
  const std::size_t kept = backwards_ ? place + 1 : place;
  if (std::min(gone, kept) < Stretch::kFixed - 1 || std::max(gone, kept) > end + 1 ||
      gone < Stretch::kFixed || gone > end) {
    return false;
  }
  const std::size_t before = backwards_ ? place + 1 : place - 1;
  const TimedMove into = {s.places_[place].point - s.places_[before].point,
                          s.places_[kept].ticks};
  // The step before may take fewer ticks than it does.
  const float spare = s.places_[kept].ticks - s.places_[kept].min_ticks;
  const float limit = s.places_[gone].ticks + s.places_[gone].bend_cost +
                      s.places_[gone + 1].bend_cost + spare - kFirstGain;
  struct Candidate {
    float cost;
    std::uint32_t point;
    bool operator<(const Candidate& o) const {
      return cost != o.cost ? cost < o.cost : point < o.point;
    }
  };
  Candidate candidates[kNear];
  std::size_t count = 0;
  for (const std::uint32_t near : near_.Of(point)) {
    const std::size_t there = s.place_[near];
    if (there + 1 == place || there == place + 1) continue;
    const Scaled step = s.places_[there].point - s.places_[place].point;
    const float ticks = s.cost_.TicksAfter(into, step);
    const float bend = s.cost_.BendCost(TickCost::Bend(into, {step, ticks}));
    const float cost = ticks + std::min(1.0F, bend);
    const float possible = spare > 0 ? std::min(cost, s.cost_.MinTicks(step)) : cost;
    if (possible < limit) candidates[count++] = {cost, near};
  }
  const std::size_t tried = std::min(count, kNearInTicks);
  std::partial_sort(candidates, candidates + tried, candidates + count);
  for (std::size_t i = 0; i < tried; ++i) {
    if (Close(Seen(place), Seen(s.place_[candidates[i].point]))) return true;
  }
  return false;
}

/// From `here` the order goes on to `there`; places as they are seen.
bool StretchSearch::Close(std::size_t here, std::size_t there) {
  return there > here ? CloseForwards(here, there) : CloseBackwards(here, there);
}

bool StretchSearch::CloseForwards(std::size_t here, std::size_t there) {
  const std::size_t begin = here + 1;
  if (Try({begin, there + 1, there + 1, true, false})) return true;
  for (const bool turned : {false, true}) {
    const std::size_t behind = turned ? 0 : 1;
    FindJoints({there, !turned, true, begin, behind, there - 1, 1 - behind});
    for (const std::size_t end : joints_) {
      if (Try({begin, there, end, turned, false})) return true;
    }
  }
  FindJoints({there, true, false, begin, 0, there + 1, 1});
  for (const std::size_t middle : joints_) {
    if (middle <= there && Try({begin, middle, there + 1, false, true})) return true;
  }
  return false;
}

bool StretchSearch::CloseBackwards(std::size_t here, std::size_t there) {
  FindJoints({there, true, true, there - 1, 0, here + 1, 1});
  for (const std::size_t middle : joints_) {
    if (Try({there, middle, here + 1, false, false})) return true;
  }
  FindJoints({there, true, false, there + 1, 1, here + 1, 0});
  for (const std::size_t begin : joints_) {
    if (Try({begin, there + 1, here + 1, true, false})) return true;
  }
  return false;
}

void StretchSearch::FindJoints(const Joints& where) {
  joints_.clear();
  const auto add_length = [&](std::size_t length) {
    if (where.forwards) joints_.push_back(where.there + length);
    if (!where.forwards && length <= where.there)
      joints_.push_back(where.there + 1 - length);
  };
  if (where.with_lengths) {
    for (const std::size_t length : {1, 2, 3}) add_length(length);
    const std::size_t smooth = SmoothLength(where.there, where.forwards);
    if (smooth > 3) add_length(smooth);
  }
  const auto add_near = [&](std::size_t place, std::size_t beside) {
    if (place >= stretch_.at_.size()) return;
    const auto near = near_.Of(stretch_.at_[Seen(place)]);
    for (const std::uint32_t point : near.first(std::min(near.size(), kNearJoints)))
      joints_.push_back(Seen(stretch_.place_[point]) + beside);
  };
  add_near(where.x, where.beside_x);
  add_near(where.y, where.beside_y);
}

/// Points from `there` on until a step takes longer.
std::size_t StretchSearch::SmoothLength(std::size_t there, bool forwards) const {
  return stretch_.SmoothLength(Seen(there), forwards != backwards_, kLongestRun);
}

/// Makes the change, of seen places, where it costs less.
bool StretchSearch::Try(const Change& seen) {
  Stretch& s = stretch_;
  const std::size_t size = s.at_.size();
  if (seen.begin >= seen.middle || seen.middle > seen.end || seen.end > size)
    return false;
  const Change change = Seen(seen);
  if (change.begin < Stretch::kFixed || change.end > size - Stretch::kFixed) return false;
  const std::size_t left = change.middle - change.begin;
  const std::size_t right = change.end - change.middle;
  if (right == 0 && (!change.turn_left || left < 2)) return false;
  if (std::min(left, right) > kLongestPiece ||
      (change.turn_left && left > kLongestTurn) ||
      (change.turn_right && right > kLongestTurn) || tries_left_ == 0) {
    return false;
  }
  --tries_left_;
  const auto gain = s.BearableGain(change, -kMinGain);
  if (!gain || *gain <= kMinGain) return false;
  Make(change);
  cost_ -= *gain;
  return true;
}

/// The change whose gain was computed last.
void StretchSearch::Make(const Change& change) {
  const std::size_t meet = change.begin + change.end - change.middle;
  if (records_) {
    const bool is_one = change.middle == change.end;
    Undoing& undoing = made_.emplace_back();
    undoing.back = {change.begin, is_one ? change.end : meet, change.end,
                    is_one || change.turn_right, !is_one && change.turn_left};
    undoing.window_count = stretch_.WindowsAround(
        {change.begin, change.middle, change.end}, undoing.windows);
    for (std::size_t w = 0; w < undoing.window_count; ++w) {
      Stretch::Window& window = undoing.windows[w];
      for (std::size_t i = window.first; i <= window.last; ++i)
        window.ticks[i - window.first] = stretch_.places_[i].ticks;
    }
  }
  stretch_.Apply(change);
  for (const std::size_t joint : {change.begin, meet, change.end}) {
    for (std::size_t i = joint - 2; i <= joint + 1; ++i) Wait(i);
  }
}

void StretchSearch::Undo() {
  for (; !made_.empty(); made_.pop_back()) {
    const Undoing& last = made_.back();
    std::copy_n(last.windows, last.window_count, stretch_.new_windows_);
    stretch_.new_window_count_ = last.window_count;
    stretch_.Apply(last.back);
  }
}

/// Makes a random change that loses few ticks; false: found none.
bool StretchSearch::Kick() {
  Stretch& s = stretch_;
  for (int i = 0; i < kKickTries && tries_left_ > 0; ++i) {
    --tries_left_;
    Change change;
    if (!s.Propose(near_, change)) continue;
    const auto gain = s.BearableGain(change, kKick);
    if (!gain) continue;
    Make(change);
    cost_ -= *gain;
    return true;
  }
  return false;
}

}  // namespace intaglio::sort
