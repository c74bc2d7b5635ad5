#include "engrave/motion/tick_planner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/motion/speed_choice.h"
#include "engrave/motion/step_motion.h"

namespace intaglio::motion {
namespace {

/// Each pass starts with the ticks of the previous one; a third pass hardly saves another
/// tick.
constexpr int kMoveAttempts = 2;

/// A third axis that is too slow for the ticks of the others gets more of them with each
/// attempt.
constexpr int kSweepAttempts = 4;
constexpr int kSweptAxis = 2;

/// How often a window is planned anew with slower steps.
constexpr int kSlowDowns = 40;
/// From a level of acceleration to the next.
constexpr double kLevelRatio = 0.75;

std::vector<StepLimits> ChoicesOf(Limits limits, double rate_hz, int levels) {
  std::vector<StepLimits> choices;
  for (int level = 0; level < levels; ++level) {
    auto of_level = StepLimitsOf(limits, rate_hz);
    // With less acceleration the planned speed is greater: a step of the first level has
    // to be able to go on behind any other.
    for (std::size_t i = 0; level > 0 && i < of_level.size(); ++i) {
      Vec3& speed_mm_s = of_level[i].planned.max_speed_mm_s;
      speed_mm_s = speed_mm_s.cwiseMin(choices[i].planned.max_speed_mm_s);
    }
    choices.insert(choices.end(), of_level.begin(), of_level.end());
    limits.max_acceleration_mm_s2 *= kLevelRatio;
    limits.max_acceleration_norm_mm_s2 *= kLevelRatio;
  }
  return choices;
}

/// Ticks in which the third axis goes from one side of its tube to the other, twice: it
/// leaves the one while the mirrors still make points there.
double TicksAcrossTube(const Limits& limits, double rate_hz, double sweep_mm) {
  const double way_mm = 2 * sweep_mm;
  const double seconds =
      2 * std::sqrt(way_mm / limits.max_acceleration_mm_s2[kSweptAxis]) +
      way_mm / limits.max_speed_mm_s[kSweptAxis];
  return std::ceil(2 * seconds * rate_hz);
}

TickPlannerOptions WithSweepAhead(TickPlannerOptions options, const Limits& limits,
                                  double rate_hz) {
  if (!(options.sweep_mm > 0)) return options;
  constexpr double kMaxAhead = 4096;
  constexpr int kWindows = 4;
  const auto ahead = static_cast<int>(
      std::min(kMaxAhead, TicksAcrossTube(limits, rate_hz, options.sweep_mm)));
  if (ahead <= options.look_ahead_points) return options;
  options.look_ahead_points = ahead;
  options.window_points = std::max(options.window_points, kWindows * ahead);
  return options;
}

}  // namespace

TickPlannerOptions OptionsForRate(double rate_hz) {
  TickPlannerOptions options;
  if (rate_hz > 250) options.labels = {16, 4};
  if (rate_hz > 1000) options.labels.extra_ticks = 8;
  return options;
}

TickPlanner::TickPlanner(const Limits& limits, double rate_hz,
                         const TickPlannerOptions& options, const KnotState& start)
    : choices_(ChoicesOf(limits, rate_hz, options.acceleration_levels)),
      full_(StepLimitsOf(limits, rate_hz)),
      rate_hz_(rate_hz),
      options_(WithSweepAhead(options, limits, rate_hz)),
      state_(start),
      labels_(choices_, static_cast<std::size_t>(options.acceleration_levels), rate_hz,
              options.labels) {
  Require(options.acceleration_levels >= 1,
          "acceleration_levels must be 1 or more, is {}", options.acceleration_levels);
  Require(options.window_points >= 2 && options.look_ahead_points >= 0 &&
              options.look_ahead_points < options.window_points,
          "a window of {} points is too small for a look-ahead of {} points",
          options.window_points, options.look_ahead_points);
  Require(options.tolerance_mm >= 0 && std::isfinite(options.tolerance_mm),
          "tolerance_mm must not be negative, is {}", options.tolerance_mm);
  Require(options.sweep_mm >= 0 && std::isfinite(options.sweep_mm),
          "sweep_mm must not be negative, is {}", options.sweep_mm);
}

void TickPlanner::Append(const Vec3& target_mm, std::int32_t point, bool pulse,
                         std::vector<Segment>& out) {
  Require(target_mm.allFinite(), "target_mm ({}, {}, {}) is not finite", target_mm.x(),
          target_mm.y(), target_mm.z());
  targets_.push_back({target_mm, point, pulse});
  if (targets_.size() < static_cast<std::size_t>(options_.window_points)) return;
  PlanWindow(false);
  HandOut(targets_.size() - static_cast<std::size_t>(options_.look_ahead_points), out);
}

void TickPlanner::Finish(std::vector<Segment>& out) {
  // A program without points, or one whose last window was returned while in motion,
  // still has to come to rest: a tick at the last target.
  const std::size_t before = out.size();
  if (targets_.empty()) targets_.push_back({state_.position_mm, -1, false});
  PlanWindow(true);
  HandOut(targets_.size(), out);
  Require(out.size() > before, "a program ended without a segment");
  out.back().program_end = true;
}

void TickPlanner::PlanWindow(bool to_end) {
  levels_.clear();
  PlanOnce(to_end);
  if (judge_ != nullptr) SlowDown(to_end);
}

// What is left of a jump of the acceleration at a point grows with it: a step is given a
// smaller acceleration, and those beside it, between which it jumps.
void TickPlanner::SlowDown(bool to_end) {
  const std::size_t count = targets_.size();
  std::vector<Segment> planned;
  std::vector<bool> too_fast;
  for (int attempt = 0; attempt < kSlowDowns; ++attempt) {
    planned.clear();
    AddSegments(count, planned);
    if (!judge_->Judge(planned, count, too_fast)) return;
    levels_.resize(count, 0);
    const auto slowest = static_cast<std::uint32_t>(options_.acceleration_levels) - 1;
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (!too_fast[i] || levels_[i] == slowest) continue;
      ++levels_[i];
      any = true;
    }
    if (!any) return;
    PlanOnce(to_end);
  }
}

void TickPlanner::AddSegments(std::size_t count, std::vector<Segment>& out) const {
  KnotState from = state_;
  for (std::size_t i = 0; i < count; ++i) {
    const TimedStep& step = way_.timed[i];
    const KnotState to{way_.points_mm[i], ends_mm_s_[i]};
    AppendStep(from, to, step.ticks, choices_[step.choice], rate_hz_, out);
    out.back().point = static_cast<std::int32_t>(i);
    from = to;
  }
}

void TickPlanner::PlanOnce(bool to_end) {
  way_.points_mm.clear();
  for (const Target& target : targets_) way_.points_mm.push_back(target.position_mm);
  if (options_.sweep_mm > 0) {
    SweepPast(to_end);
  } else {
    PlanThrough(way_);
  }
  if (options_.tolerance_mm > 0) MovePoints();
  ChooseSpeeds(state_.velocity_mm_s, way_.steps_mm, way_.timed, way_.near_walls, choices_,
               rate_hz_, options_.sweeps, ends_mm_s_);
}

void TickPlanner::PlanThrough(Way& way) {
  way.steps_mm.clear();
  Vec3 at_mm = state_.position_mm;
  Box3 extent_mm{at_mm, at_mm};
  for (const Vec3& point : way.points_mm) {
    way.steps_mm.push_back(point - at_mm);
    at_mm = point;
    extent_mm.Extend(at_mm);
  }
  way.near_walls = NearWalls(levels_.empty() ? full_ : choices_, extent_mm, rate_hz_);
  labels_.Choose(state_, way.steps_mm, way.near_walls, levels_, way.timed);
  way.ticks = 0;
  for (const TimedStep& step : way.timed) way.ticks += step.ticks;
}

// First the ticks that the other two axes take by themselves, then the course of the
// third at the times of these, then the ticks of all three; those are the times of the
// next attempt.
void TickPlanner::SweepPast(bool to_end) {
  const std::size_t count = targets_.size();
  heights_mm_.clear();
  seconds_.resize(count);
  for (const Target& target : targets_) {
    heights_mm_.push_back(target.position_mm[kSweptAxis]);
  }
  const KnotState state = state_;
  const double height_mm = state.position_mm[kSweptAxis];
  for (Vec3& point : way_.points_mm) point[kSweptAxis] = height_mm;
  state_.velocity_mm_s[kSweptAxis] = 0;
  PlanThrough(way_);
  state_ = state;
  const std::uint64_t fewest = way_.ticks;
  const Box3& travel_mm = choices_[0].whole.travel_mm;
  bool any = false;
  for (int attempt = 0; attempt < kSweepAttempts; ++attempt) {
    const Way& timed = attempt == 0 ? way_ : moved_way_;
    for (std::size_t i = 0; i < count; ++i) seconds_[i] = timed.timed[i].ticks / rate_hz_;
    sweep_.Solve({height_mm, state_.velocity_mm_s[kSweptAxis]}, heights_mm_, seconds_,
                 options_.sweep_mm,
                 choices_[0].planned.max_acceleration_mm_s2[kSweptAxis], to_end,
                 swept_mm_);
    moved_way_.points_mm.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      Vec3& point = moved_way_.points_mm[i] = targets_[i].position_mm;
      // A target beyond the travel stays on its side of it.
      point[kSweptAxis] =
          std::clamp(swept_mm_[i], std::min(travel_mm.min_mm[kSweptAxis], heights_mm_[i]),
                     std::max(travel_mm.max_mm[kSweptAxis], heights_mm_[i]));
    }
    PlanThrough(moved_way_);
    if (!any || moved_way_.ticks < best_way_.ticks) best_way_ = moved_way_;
    any = true;
    if (best_way_.ticks <= fewest) break;
  }
  std::swap(way_, best_way_);
}

void TickPlanner::MovePoints() {
  const std::vector<Vec3> targets_mm = way_.points_mm;
  for (int attempt = 0; attempt < kMoveAttempts; ++attempt) {
    if (way_.ticks == targets_mm.size()) return;
    ShiftPoints(state_, targets_mm, way_.timed, rate_hz_, options_.tolerance_mm,
                choices_[0].whole.travel_mm, moved_way_.points_mm);
    PlanThrough(moved_way_);
    if (moved_way_.ticks >= way_.ticks) return;
    std::swap(way_, moved_way_);
  }
}

void TickPlanner::HandOut(std::size_t count, std::vector<Segment>& out) {
  for (std::size_t i = 0; i < count; ++i) {
    const TimedStep& step = way_.timed[i];
    const KnotState to{way_.points_mm[i], ends_mm_s_[i]};
    AppendStep(state_, to, step.ticks, choices_[step.choice], rate_hz_, out);
    out.back().point = targets_[i].point;
    out.back().pulse = targets_[i].pulse;
    if (targets_[i].point >= 0) {
      moves_.Add((to.position_mm - targets_[i].position_mm).norm());
    }
    state_ = to;
    ticks_ += step.ticks;
  }
  targets_.erase(targets_.begin(), targets_.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace intaglio::motion
