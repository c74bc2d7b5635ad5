#include "services/synchronizer/pulses/pulse_schedule.h"

#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;
using link::TickOutcome;

struct Meaning {
  PointOutcome outcome;
  SkipReason reason;
};

Meaning MeaningOf(TickOutcome outcome) {
  switch (outcome) {
    case TickOutcome::kNotArmed:
      return {PointOutcome::kSkipped, SkipReason::kLink};
    case TickOutcome::kFiredSeen:
      return {PointOutcome::kMade, SkipReason::kNone};
    case TickOutcome::kFiredUnseen:
      return {PointOutcome::kMissed, SkipReason::kNone};
    case TickOutcome::kNotInPosition:
      return {PointOutcome::kSkipped, SkipReason::kPosition};
    case TickOutcome::kInterlocked:
      return {PointOutcome::kSkipped, SkipReason::kInterlock};
    case TickOutcome::kLampNotReady:
      return {PointOutcome::kSkipped, SkipReason::kLamp};
    case TickOutcome::kShutterClosed:
      return {PointOutcome::kSkipped, SkipReason::kShutter};
    case TickOutcome::kTooLate:
      return {PointOutcome::kSkipped, SkipReason::kLate};
    case TickOutcome::kTriggerOutside:
      return {PointOutcome::kSkipped, SkipReason::kTrigger};
    case TickOutcome::kEnergyOutside:
      return {PointOutcome::kSkipped, SkipReason::kEnergy};
    case TickOutcome::kNoLongerKnown:
      break;
  }
  return {PointOutcome::kUncertain, SkipReason::kNone};
}

}  // namespace

void PulseSchedule::Add(std::uint64_t tick, std::uint32_t point) {
  Require(entries_.empty() || entries_.back().tick < tick,
          "tick {} does not follow the schedule's last one", tick);
  entries_.push_back({tick, point});
}

link::ArmWindow PulseSchedule::Decide(
    std::uint64_t first, std::uint64_t last,
    const std::function<void(std::uint64_t, std::uint32_t)>& armed,
    const std::function<void(std::uint32_t)>& late) {
  Require(first <= last && last - first < link::kMaxArmTicks,
          "ticks {}..{} are no window", first, last);
  link::ArmWindow window{first, true, std::vector<bool>(last - first + 1, false)};
  while (decided_ < entries_.size() && entries_[decided_].tick < first) {
    late(entries_[decided_].point);
    entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(decided_));
  }
  for (; decided_ < entries_.size() && entries_[decided_].tick <= last; ++decided_) {
    Entry& entry = entries_[decided_];
    entry.armed = true;
    ++armed_count_;
    window.fire[entry.tick - first] = true;
    armed(entry.tick, entry.point);
  }
  return window;
}

PulseSchedule::AlikeTicks PulseSchedule::AlikeFrom(
    std::uint64_t first, std::uint64_t last,
    const std::function<double(std::uint32_t point)>& value_of) const {
  AlikeTicks alike{last, 0};
  bool has_point = false;
  for (std::size_t i = decided_; i < entries_.size() && entries_[i].tick <= last; ++i) {
    if (entries_[i].tick < first) continue;  // too late to be decided
    const double value = value_of(entries_[i].point);
    if (has_point && value != alike.value) {
      alike.last = entries_[i].tick - 1;
      break;
    }
    has_point = true;
    alike.value = value;
  }
  return alike;
}

std::uint64_t PulseSchedule::LastTickFor(std::size_t count) const {
  const std::size_t room = count - std::min(count, armed_count_);
  const std::size_t first_beyond = decided_ + room;
  return first_beyond < entries_.size() ? entries_[first_beyond].tick - 1 : UINT64_MAX;
}

PulseSchedule::Entry* PulseSchedule::Find(std::uint64_t tick) {
  const auto found = std::lower_bound(
      entries_.begin(), entries_.end(), tick,
      [](const Entry& entry, std::uint64_t t) { return entry.tick < t; });
  return found != entries_.end() && found->tick == tick ? &*found : nullptr;
}

void PulseSchedule::SettleOne(Entry& entry, PulseResult result, const ResultSink& sink) {
  if (!entry.armed || entry.settled) return;
  entry.settled = true;
  --armed_count_;
  result.tick = entry.tick;
  result.point = entry.point;
  sink(result);
}

bool PulseSchedule::AddArmed(std::uint64_t tick, std::uint32_t point) {
  if (!entries_.empty() && entries_.back().tick >= tick) return false;
  entries_.push_back({tick, point, true});
  decided_ = entries_.size();
  ++armed_count_;
  return true;
}

void PulseSchedule::ApplyOne(TickOutcome outcome, PulseResult result,
                             const ResultSink& sink) {
  Entry* entry = Find(result.tick);
  if (entry == nullptr) return;
  const Meaning meaning = MeaningOf(outcome);
  result.outcome = meaning.outcome;
  result.reason = meaning.reason;
  SettleOne(*entry, result, sink);
}

void PulseSchedule::Apply(const link::PulseReport& report, const ResultSink& sink) {
  for (std::size_t i = 0; i < report.outcome.size(); ++i) {
    if (report.outcome[i] == TickOutcome::kNotArmed) continue;
    PulseResult result{report.first_tick + i};
    if (i < report.missed.size()) result.missed_channels = report.missed[i];
    if (i < report.measured_mj.size()) result.measured_mj = report.measured_mj[i];
    ApplyOne(report.outcome[i], result, sink);
  }
  PopSettled();
}

void PulseSchedule::Apply(const link::PastReport& report, const ResultSink& sink) {
  for (std::size_t i = 0; i < report.outcome.size(); ++i) {
    PulseResult result{report.first_tick + i};
    if (i < report.missed.size()) result.missed_channels = report.missed[i];
    ApplyOne(report.outcome[i], result, sink);
  }
  PopSettled();
}

std::vector<PulseResult> PulseSchedule::ArmedWithin(std::uint64_t first,
                                                    std::uint64_t last) const {
  std::vector<PulseResult> found;
  for (const Entry& entry : entries_) {
    if (entry.armed && !entry.settled && entry.tick >= first && entry.tick <= last) {
      found.push_back({entry.tick, entry.point, PointOutcome::kNone, SkipReason::kNone});
    }
  }
  return found;
}

std::vector<PulseResult> PulseSchedule::OpenAfter(std::uint64_t tick) const {
  std::vector<PulseResult> found;
  for (const Entry& entry : entries_)
    if (!entry.settled && entry.tick > tick) found.push_back({entry.tick, entry.point});
  return found;
}

void PulseSchedule::Settle(const std::vector<PulseResult>& results,
                           const ResultSink& sink) {
  for (const PulseResult& result : results) {
    Entry* entry = Find(result.tick);
    if (entry != nullptr) SettleOne(*entry, result, sink);
  }
  PopSettled();
}

void PulseSchedule::DropUnarmed() {
  std::erase_if(entries_, [](const Entry& entry) { return !entry.armed; });
  decided_ = entries_.size();
}

void PulseSchedule::PopSettled() {
  while (!entries_.empty() && entries_.front().settled) {
    entries_.pop_front();
    --decided_;
  }
}

}  // namespace intaglio::synchronizer
