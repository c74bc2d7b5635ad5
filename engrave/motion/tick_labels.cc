#include "engrave/motion/tick_labels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/check.h"

// Given time, every state within the limits leads to every other: so each label is tried
// with more and more ticks until the step can be made, and at the last step until it can
// end at rest. A way is never lost by keeping few labels; it only gets longer.

namespace intaglio::motion {
namespace {

/// What an open choice of velocity is worth, of the time it takes to change from one end
/// of it to the other. By trial: with 0.3 fewest ticks are lost by keeping few labels,
/// from 100 Hz to 4 kHz; with 0 a tenth more at 4 kHz, with 1 half of that.
constexpr double kChoiceWorthRatio = 0.3;

constexpr double kRoundingMm = 1e-9;

}  // namespace

TickLabels::TickLabels(std::vector<StepLimits> choices, double rate_hz,
                       const LabelOptions& options)
    : choices_(std::move(choices)),
      fastest_mm_s_(Vec3::Zero()),
      rate_hz_(rate_hz),
      options_(options) {
  Require(rate_hz > 0 && std::isfinite(rate_hz), "rate_hz must be positive, is {}",
          rate_hz);
  Require(options.width >= 1 && options.extra_ticks >= 0,
          "width must be 1 or more and extra_ticks 0 or more, are {} and {}",
          options.width, options.extra_ticks);
  for (const StepLimits& choice : choices_) {
    RequireUsable(choice.planned);
    fastest_mm_s_ = fastest_mm_s_.cwiseMax(choice.planned.max_speed_mm_s);
  }
}

template <bool kPlain>
void TickLabels::Open(const Vec3& start_mm, const Trial& trial) {
  const StepLimits& limits = choices_[trial.choice];
  const double seconds = trial.ticks / rate_hz_;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = trial.step_mm[axis];
    if constexpr (kPlain) {
      usable_[axis] = UsableStartSpeeds(step, seconds, LimitsOf(limits.planned, axis));
      continue;
    }
    usable_[axis] = UsableStartSpeeds(step, seconds, axis, limits);
    if (!near_walls_) continue;
    // A state at the limit must not be lost by the last bit of its position.
    usable_[axis] = Intersection(
        usable_[axis], SpeedsAt(start_mm[axis], axis, limits, rate_hz_, kRoundingMm));
    open_[axis] = SpeedsAt(start_mm[axis] + step, axis, limits, rate_hz_);
  }
}

template <bool kPlain>
bool TickLabels::MakeLabel(std::uint32_t from_index, const Trial& trial,
                           Label& to) const {
  const Label& from = labels_[from_index];
  for (int axis = 0; axis < 3; ++axis) {
    to.box.axis[axis] = Intersection(from.box.axis[axis], usable_[axis]);
    if (to.box.axis[axis].empty()) return false;
  }
  const StepLimits& limits = choices_[trial.choice];
  const double seconds = trial.ticks / rate_hz_;
  for (int axis = 0; axis < 3; ++axis) {
    SpeedInterval& speeds = to.box.axis[axis];
    const double step = trial.step_mm[axis];
    if constexpr (kPlain) {
      speeds = ReachableEndSpeeds(speeds, step, seconds, LimitsOf(limits.planned, axis));
      continue;
    }
    speeds = ReachableEndSpeeds(speeds, step, seconds, axis, limits);
    if (!near_walls_) continue;
    speeds = Intersection(speeds, open_[axis]);
    if (speeds.empty()) return false;
  }
  to.ticks = from.ticks + trial.ticks;
  to.step_ticks = trial.ticks;
  to.choice = trial.choice;
  to.parent = static_cast<std::int32_t>(from_index);
  return true;
}

void TickLabels::Offer(const Label& label) {
  for (const Label& other : offered_) {
    if (other.ticks <= label.ticks && other.box.Covers(label.box)) return;
  }
  std::erase_if(offered_, [&](const Label& other) {
    return label.ticks <= other.ticks && label.box.Covers(other.box);
  });
  offered_.push_back(label);
}

/// Whether more ticks are worth a try of any label.
template <bool kPlain>
bool TickLabels::TryAll(const Trial& trial, bool to_rest) {
  const std::uint32_t begin = first_.back();
  const auto end = static_cast<std::uint32_t>(begin + last_.size());
  bool more = false;
  for (std::uint32_t i = begin; i < end; ++i) {
    const bool late = labels_[i].ticks + trial.ticks > rest_ticks_;
    if (late || trial.ticks > last_[i - begin]) continue;
    more = true;
    Label label;
    if (!MakeLabel<kPlain>(i, trial, label)) continue;
    const bool has_rest = label.box.HasRest();
    if (has_rest) rest_ticks_ = std::min(rest_ticks_, label.ticks);
    if (to_rest && !has_rest) continue;
    if (last_[i - begin] == UINT32_MAX) {
      last_[i - begin] = trial.ticks + static_cast<std::uint32_t>(options_.extra_ticks);
    }
    Offer(label);
  }
  return more;
}

template <bool kPlain>
void TickLabels::Extend(const Vec3& start_mm, const Vec3& step_mm, bool to_rest) {
  const auto end = static_cast<std::uint32_t>(labels_.size());
  offered_.clear();
  // The last count worth a try of each label, known once it had a first success.
  last_.assign(end - first_.back(), UINT32_MAX);
  rest_ticks_ = UINT32_MAX;
  const double least_s = (step_mm.cwiseAbs().array() / fastest_mm_s_.array()).maxCoeff();
  auto ticks = static_cast<std::uint32_t>(WholeTicks(least_s, rate_hz_));
  for (bool more = true; more; ++ticks) {
    more = false;
    for (std::uint32_t choice = 0; choice < choices_.size(); ++choice) {
      const Trial trial{step_mm, ticks, choice};
      Open<kPlain>(start_mm, trial);
      more |= TryAll<kPlain>(trial, to_rest);
    }
  }
  first_.push_back(end);
  KeepBest();
}

double TickLabels::Score(const Label& label) const {
  double choice_s = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const SpeedInterval& speeds = label.box.axis[axis];
    choice_s +=
        (speeds.hi - speeds.lo) / choices_[0].planned.max_acceleration_mm_s2[axis];
  }
  return label.ticks - kChoiceWorthRatio * rate_hz_ * choice_s;
}

void TickLabels::KeepBest() {
  const auto width = static_cast<std::size_t>(options_.width);
  if (offered_.size() > width) {
    for (Label& label : offered_) label.score = Score(label);
    const auto better = [](const Label& a, const Label& b) { return a.score < b.score; };
    std::nth_element(offered_.begin(), offered_.begin() + options_.width, offered_.end(),
                     better);
    offered_.resize(width);
  }
  labels_.insert(labels_.end(), offered_.begin(), offered_.end());
}

void TickLabels::Choose(const KnotState& start, std::span<const Vec3> steps_mm,
                        bool near_walls, std::vector<TimedStep>& timed) {
  near_walls_ = near_walls;
  const bool is_plain = !near_walls && IsPlain(choices_);
  labels_.clear();
  first_.assign(1, 0);
  Label first;
  for (int axis = 0; axis < 3; ++axis) {
    first.box.axis[axis] = {start.velocity_mm_s[axis], start.velocity_mm_s[axis]};
  }
  labels_.push_back(first);
  Vec3 at_mm = start.position_mm;
  for (std::size_t i = 0; i < steps_mm.size(); ++i) {
    const bool to_rest = i + 1 == steps_mm.size();
    if (is_plain) {
      Extend<true>(at_mm, steps_mm[i], to_rest);
    } else {
      Extend<false>(at_mm, steps_mm[i], to_rest);
    }
    at_mm += steps_mm[i];
  }
  auto label =
      std::min_element(labels_.begin() + first_.back(), labels_.end(),
                       [](const Label& a, const Label& b) { return a.ticks < b.ticks; });
  timed.resize(steps_mm.size());
  for (std::size_t i = steps_mm.size(); i-- > 0;) {
    timed[i] = {label->step_ticks, label->choice, label->box};
    label = labels_.begin() + label->parent;
  }
  if (timed.empty()) return;
  for (SpeedInterval& axis : timed.back().box.axis) axis = {0, 0};
  if (near_walls_) KeepOpen(start, steps_mm, timed);
}

/// Takes from each box what the step behind it may not start with.
void TickLabels::KeepOpen(const KnotState& start, std::span<const Vec3> steps_mm,
                          std::vector<TimedStep>& timed) const {
  Vec3 at_mm = start.position_mm;
  for (std::size_t i = 0; i + 1 < timed.size(); ++i) {
    at_mm += steps_mm[i];
    for (int axis = 0; axis < 3; ++axis) {
      SpeedInterval& speeds = timed[i].box.axis[axis];
      speeds =
          Intersection(speeds, SpeedsAt(at_mm[axis], axis, choices_[timed[i + 1].choice],
                                        rate_hz_, kRoundingMm));
    }
  }
}

}  // namespace intaglio::motion
