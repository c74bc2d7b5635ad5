#include "engrave/motion/tick_labels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/motion/axis/jerk_reach.h"

// Given time, every state within the limits leads to every other: so each label is tried
// with more and more ticks until the step can be made, and at the last step until it can
// end at rest. A solution is never lost by keeping few labels; it only gets longer.

namespace intaglio::motion {
namespace {

/// The value of a free range of velocities, as a share of the time to change from one end
/// of it to the other. By experiment: with 0.3 the fewest ticks are lost by keeping few
/// labels, from 100 Hz to 4 kHz; with 0 a tenth more at 4 kHz, with 1 half of that.
constexpr double kChoiceWorthRatio = 0.3;

constexpr double kRoundingMm = 1e-9;

/// A step of a higher level may not be possible at all from a label of a lower one, near
/// walls: after so many ticks it takes level 0.
constexpr std::uint32_t kFallbackTicks = 64;

}  // namespace

TickLabels::TickLabels(std::vector<StepLimits> choices, std::size_t levels,
                       double rate_hz, const LabelOptions& options)
    : choices_(std::move(choices)),
      level_size_(static_cast<std::uint32_t>(choices_.size() / levels)),
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

bool TickLabels::Label::Covers(const Label& other) const {
  const auto covered =
      (box[0] <= other.box[0]) & (box[1] <= other.box[1]) & (box[2] <= other.box[2]);
  return (covered[0] & covered[1]) != 0;
}

bool TickLabels::Label::HasRest() const {
  const auto rests = (box[0] <= 0.0) & (box[1] <= 0.0) & (box[2] <= 0.0);
  return (rests[0] & rests[1]) != 0;
}

TickLabels::Trial TickLabels::MakeTrial(const Vec3& start_mm, const Vec3& step_mm,
                                        std::uint32_t ticks, std::uint32_t choice) const {
  const double seconds = ticks / rate_hz_;
  const auto reach = [&](int axis) {
    return AxisReach(step_mm[axis], seconds, LimitsOf(choices_[choice].planned, axis));
  };
  return {start_mm, step_mm, ticks, choice, seconds, {reach(0), reach(1), reach(2)}};
}

template <bool kPlain>
void TickLabels::Open(const Trial& trial) {
  const StepLimits& limits = choices_[trial.choice];
  for (int axis = 0; axis < 3; ++axis) {
    const double step = trial.step_mm[axis], start = trial.start_mm[axis];
    if (kPlain || !limits.jerk_limited(axis)) {
      usable_[axis] = trial.reach[axis].Usable();
    } else {
      usable_[axis] = EndsOf(
          UsableStartSpeeds(step, trial.seconds, JerkLimitsOf(limits.planned, axis)));
    }
    if (kPlain || !near_walls_) continue;
    // A state at the limit must not be lost because of the last bit of its position.
    usable_[axis] = Intersection(
        usable_[axis], EndsOf(SpeedsAt(start, axis, limits, rate_hz_, kRoundingMm)));
    open_[axis] = EndsOf(SpeedsAt(start + step, axis, limits, rate_hz_));
  }
}

template <bool kPlain>
bool TickLabels::MakeLabel(std::uint32_t from_index, const Trial& trial,
                           Label& to) const {
  const Label& from = labels_[from_index];
  bool empty = false;
  for (int axis = 0; axis < 3; ++axis) {
    to.box[axis] = Intersection(from.box[axis], usable_[axis]);
    empty |= IsEmpty(to.box[axis]);
  }
  if (empty) return false;
  const StepLimits& limits = choices_[trial.choice];
  for (int axis = 0; axis < 3; ++axis) {
    SpeedEnds& speeds = to.box[axis];
    if (kPlain || !limits.jerk_limited(axis)) {
      speeds = trial.reach[axis].After(speeds);
    } else {
      speeds =
          EndsOf(ReachableEndSpeeds(IntervalOf(speeds), trial.step_mm[axis],
                                    trial.seconds, JerkLimitsOf(limits.planned, axis)));
    }
    if (kPlain || !near_walls_) continue;
    speeds = Intersection(speeds, open_[axis]);
    if (IsEmpty(speeds)) return false;
  }
  to.ticks = from.ticks + trial.ticks;
  to.step_ticks = trial.ticks;
  to.choice = trial.choice;
  to.parent = static_cast<std::int32_t>(from_index);
  return true;
}

void TickLabels::Offer(const Label& label) {
  for (const Label& other : offered_) {
    if (other.ticks <= label.ticks && other.Covers(label)) return;
  }
  std::erase_if(offered_, [&](const Label& other) {
    return label.ticks <= other.ticks && label.Covers(other);
  });
  offered_.push_back(label);
}

bool TickLabels::IsWorthATry(std::uint32_t label, std::uint32_t ticks) const {
  return labels_[first_.back() + label].ticks + ticks <= rest_ticks_ &&
         ticks <= last_[label];
}

bool TickLabels::IsWorthATry(std::uint32_t ticks) const {
  for (std::uint32_t i = 0; i < last_.size(); ++i) {
    if (IsWorthATry(i, ticks)) return true;
  }
  return false;
}

template <bool kPlain>
void TickLabels::TryAll(const Trial& trial, bool to_rest) {
  for (std::uint32_t i = 0; i < last_.size(); ++i) {
    if (!IsWorthATry(i, trial.ticks)) continue;
    Label label;
    if (!MakeLabel<kPlain>(first_.back() + i, trial, label)) continue;
    const bool has_rest = label.HasRest();
    if (has_rest) rest_ticks_ = std::min(rest_ticks_, label.ticks);
    if (to_rest && !has_rest) continue;
    if (last_[i] == UINT32_MAX) {
      last_[i] = trial.ticks + static_cast<std::uint32_t>(options_.extra_ticks);
    }
    Offer(label);
  }
}

template <bool kPlain>
void TickLabels::Extend(const Vec3& start_mm, const Vec3& step_mm, std::uint32_t level,
                        bool to_rest) {
  const auto end = static_cast<std::uint32_t>(labels_.size());
  offered_.clear();
  // The last number of ticks to try for each label, set once it had a first success.
  last_.assign(end - first_.back(), UINT32_MAX);
  rest_ticks_ = UINT32_MAX;
  const double min_s = (step_mm.cwiseAbs().array() / fastest_mm_s_.array()).maxCoeff();
  const std::uint32_t first = level * level_size_, behind = first + level_size_;
  auto ticks = static_cast<std::uint32_t>(WholeTicks(min_s, rate_hz_));
  const std::uint32_t fallback = ticks + kFallbackTicks;
  for (; IsWorthATry(ticks); ++ticks) {
    for (std::uint32_t choice = 0; choice < behind; ++choice) {
      if (choice < first && !(ticks > fallback && choice < level_size_)) continue;
      const Trial trial = MakeTrial(start_mm, step_mm, ticks, choice);
      Open<kPlain>(trial);
      TryAll<kPlain>(trial, to_rest);
    }
  }
  first_.push_back(end);
  KeepBest();
}

double TickLabels::Score(const Label& label) const {
  double choice_s = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const SpeedInterval speeds = IntervalOf(label.box[axis]);
    choice_s +=
        (speeds.hi - speeds.lo) / choices_[0].planned.max_acceleration_mm_s2[axis];
  }
  return label.ticks - kChoiceWorthRatio * rate_hz_ * choice_s;
}

void TickLabels::KeepBest() {
  const auto width = static_cast<std::size_t>(options_.width);
  if (offered_.size() <= width) {
    labels_.insert(labels_.end(), offered_.begin(), offered_.end());
    return;
  }
  scored_.clear();
  for (std::uint32_t i = 0; i < offered_.size(); ++i) {
    scored_.push_back({Score(offered_[i]), i});
  }
  std::nth_element(scored_.begin(), scored_.begin() + options_.width, scored_.end(),
                   [](const Scored& a, const Scored& b) { return a.score < b.score; });
  for (std::size_t i = 0; i < width; ++i) {
    labels_.push_back(offered_[scored_[i].index]);
  }
}

void TickLabels::Choose(const KnotState& start, std::span<const Vec3> steps_mm,
                        bool near_walls, std::span<const std::uint32_t> levels,
                        std::vector<TimedStep>& timed) {
  near_walls_ = near_walls;
  const bool is_plain = !near_walls && IsPlain(choices_);
  labels_.clear();
  first_.assign(1, 0);
  Label first;
  for (int axis = 0; axis < 3; ++axis) {
    const double speed = start.velocity_mm_s[axis];
    first.box[axis] = EndsOf({speed, speed});
  }
  labels_.push_back(first);
  Vec3 at_mm = start.position_mm;
  for (std::size_t i = 0; i < steps_mm.size(); ++i) {
    const bool to_rest = i + 1 == steps_mm.size();
    const std::uint32_t level = levels.empty() ? 0 : levels[i];
    if (is_plain) {
      Extend<true>(at_mm, steps_mm[i], level, to_rest);
    } else {
      Extend<false>(at_mm, steps_mm[i], level, to_rest);
    }
    at_mm += steps_mm[i];
  }
  auto label =
      std::min_element(labels_.begin() + first_.back(), labels_.end(),
                       [](const Label& a, const Label& b) { return a.ticks < b.ticks; });
  timed.resize(steps_mm.size());
  for (std::size_t i = steps_mm.size(); i-- > 0;) {
    const VelocityBox box{IntervalOf(label->box[0]), IntervalOf(label->box[1]),
                          IntervalOf(label->box[2])};
    timed[i] = {label->step_ticks, label->choice, box};
    label = labels_.begin() + label->parent;
  }
  if (timed.empty()) return;
  for (SpeedInterval& axis : timed.back().box.axis) axis = {0, 0};
  if (near_walls_) KeepOpen(start, steps_mm, timed);
}

/// Removes from each box the velocities with which the step behind it cannot start.
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
