#include "engrave/motion/tick_labels.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

TickLabels::TickLabels(const Limits& limits, double rate_hz, const LabelOptions& options)
    : limits_(limits), rate_hz_(rate_hz), options_(options) {
  RequireUsable(limits);
  Require(rate_hz > 0 && std::isfinite(rate_hz), "rate_hz must be positive, is {}",
          rate_hz);
  Require(options.width >= 1 && options.extra_ticks >= 0,
          "width must be 1 or more and extra_ticks 0 or more, are {} and {}",
          options.width, options.extra_ticks);
}

bool TickLabels::MakeLabel(std::uint32_t from_index, std::uint32_t ticks,
                           const Vec3& step_mm, const SpeedInterval usable[3],
                           Label& to) const {
  const Label& from = labels_[from_index];
  for (int axis = 0; axis < 3; ++axis) {
    to.box.axis[axis] = Intersection(from.box.axis[axis], usable[axis]);
    if (to.box.axis[axis].empty()) return false;
  }
  const double seconds = ticks / rate_hz_;
  for (int axis = 0; axis < 3; ++axis) {
    to.box.axis[axis] = ReachableEndSpeeds(to.box.axis[axis], step_mm[axis], seconds,
                                           LimitsOf(limits_, axis));
  }
  to.ticks = from.ticks + ticks;
  to.step_ticks = ticks;
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

void TickLabels::Extend(const Vec3& step_mm, bool to_rest) {
  const std::uint32_t begin = first_.back();
  const auto end = static_cast<std::uint32_t>(labels_.size());
  offered_.clear();
  // The last count worth a try of each label, known once it had a first success.
  last_.assign(end - begin, UINT32_MAX);
  std::uint32_t rest_ticks = UINT32_MAX;
  const double least_s =
      (step_mm.cwiseAbs().array() / limits_.max_speed_mm_s.array()).maxCoeff();
  auto ticks = static_cast<std::uint32_t>(WholeTicks(least_s, rate_hz_));
  for (bool more = true; more; ++ticks) {
    SpeedInterval usable[3];
    for (int axis = 0; axis < 3; ++axis) {
      usable[axis] =
          UsableStartSpeeds(step_mm[axis], ticks / rate_hz_, LimitsOf(limits_, axis));
    }
    more = false;
    for (std::uint32_t i = begin; i < end; ++i) {
      const bool late = labels_[i].ticks + ticks > rest_ticks;
      if (late || ticks > last_[i - begin]) continue;
      more = true;
      Label label;
      if (!MakeLabel(i, ticks, step_mm, usable, label)) continue;
      const bool has_rest = label.box.HasRest();
      if (has_rest) rest_ticks = std::min(rest_ticks, label.ticks);
      if (to_rest && !has_rest) continue;
      if (last_[i - begin] == UINT32_MAX) {
        last_[i - begin] = ticks + static_cast<std::uint32_t>(options_.extra_ticks);
      }
      Offer(label);
    }
  }
  first_.push_back(end);
  KeepBest();
}

double TickLabels::Score(const Label& label) const {
  double choice_s = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const SpeedInterval& speeds = label.box.axis[axis];
    choice_s += (speeds.hi - speeds.lo) / limits_.max_acceleration_mm_s2[axis];
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

void TickLabels::Choose(const Vec3& start_mm_s, std::span<const Vec3> steps_mm,
                        std::vector<TimedStep>& timed) {
  labels_.clear();
  first_.assign(1, 0);
  Label start;
  for (int axis = 0; axis < 3; ++axis) {
    start.box.axis[axis] = {start_mm_s[axis], start_mm_s[axis]};
  }
  labels_.push_back(start);
  for (std::size_t i = 0; i < steps_mm.size(); ++i) {
    Extend(steps_mm[i], i + 1 == steps_mm.size());
  }
  auto label =
      std::min_element(labels_.begin() + first_.back(), labels_.end(),
                       [](const Label& a, const Label& b) { return a.ticks < b.ticks; });
  timed.resize(steps_mm.size());
  for (std::size_t i = steps_mm.size(); i-- > 0;) {
    timed[i] = {label->step_ticks, label->box};
    label = labels_.begin() + label->parent;
  }
  if (!timed.empty()) {
    for (SpeedInterval& axis : timed.back().box.axis) axis = {0, 0};
  }
}

}  // namespace intaglio::motion
