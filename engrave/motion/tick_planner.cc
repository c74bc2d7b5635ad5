#include "engrave/motion/tick_planner.h"

#include "engrave/core/check.h"
#include "engrave/motion/speed_choice.h"
#include "engrave/motion/step_motion.h"

namespace intaglio::motion {
TickPlannerOptions OptionsForRate(double rate_hz) {
  TickPlannerOptions options;
  if (rate_hz > 250) options.labels = {16, 4};
  if (rate_hz > 1000) options.labels.extra_ticks = 8;
  return options;
}

TickPlanner::TickPlanner(const Limits& limits, double rate_hz,
                         const TickPlannerOptions& options, const KnotState& start)
    : choices_(StepLimitsOf(limits, rate_hz)),
      rate_hz_(rate_hz),
      options_(options),
      state_(start),
      labels_(choices_, rate_hz, options.labels) {
  Require(options.window_points >= 2 && options.look_ahead_points >= 0 &&
              options.look_ahead_points < options.window_points,
          "a window of {} points cannot look {} points ahead", options.window_points,
          options.look_ahead_points);
}

void TickPlanner::Append(const Vec3& target_mm, std::int32_t point, bool pulse,
                         std::vector<Segment>& out) {
  Require(target_mm.allFinite(), "target_mm ({}, {}, {}) is not finite", target_mm.x(),
          target_mm.y(), target_mm.z());
  targets_.push_back({target_mm, point, pulse});
  if (targets_.size() < static_cast<std::size_t>(options_.window_points)) return;
  PlanWindow();
  HandOut(targets_.size() - static_cast<std::size_t>(options_.look_ahead_points), out);
}

void TickPlanner::Finish(std::vector<Segment>& out) {
  // A program without points, or one whose last window was handed out in motion, still
  // comes to rest somewhere: a tick at the last target.
  const std::size_t before = out.size();
  if (targets_.empty()) targets_.push_back({state_.position_mm, -1, false});
  PlanWindow();
  HandOut(targets_.size(), out);
  Require(out.size() > before, "a program ended without a segment");
  out.back().program_end = true;
}

void TickPlanner::PlanWindow() {
  steps_mm_.clear();
  Vec3 at_mm = state_.position_mm;
  Box3 extent_mm{at_mm, at_mm};
  for (const Target& target : targets_) {
    steps_mm_.push_back(target.position_mm - at_mm);
    at_mm = target.position_mm;
    extent_mm.Extend(at_mm);
  }
  const bool near_walls = NearWalls(choices_, extent_mm, rate_hz_);
  labels_.Choose(state_, steps_mm_, near_walls, timed_);
  ChooseSpeeds(state_.velocity_mm_s, steps_mm_, timed_, near_walls, choices_, rate_hz_,
               options_.sweeps, ends_mm_s_);
}

void TickPlanner::HandOut(std::size_t count, std::vector<Segment>& out) {
  for (std::size_t i = 0; i < count; ++i) {
    const KnotState to{targets_[i].position_mm, ends_mm_s_[i]};
    AppendStep(state_, to, timed_[i].ticks, choices_[timed_[i].choice], rate_hz_, out);
    out.back().point = targets_[i].point;
    out.back().pulse = targets_[i].pulse;
    state_ = to;
    ticks_ += timed_[i].ticks;
  }
  targets_.erase(targets_.begin(), targets_.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace intaglio::motion
