#include "services/synchronizer/pulses/tick_windows.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::synchronizer {

void TickWindows::Begin(std::uint64_t tick, bool lockstep) {
  session_ = laser_.session();
  decided_ = std::max({tick, laser_.status().decided_through, lockstep ? decided_ : 0});
  sent_through_ = reported_through_ = decided_;
  held_.clear();
  lost_places_ = marks_owed_ = false;
  last_unplaced_ = 0;
  others_.clear();
}

bool TickWindows::Arm(std::uint64_t last,
                      const std::function<double(std::uint32_t point)>& energy_mj_of,
                      const std::function<void(std::uint32_t point)>& late,
                      const PulseTrigger& trigger) {
  bool kept = true;
  while (kept && decided_ < last) {
    const PulseSchedule::AlikeTicks alike =
        schedule_.AlikeFrom(decided_ + 1, last, energy_mj_of);
    kept = ArmOne(alike.last, alike.value, late, trigger);
  }
  if (kept) record_.Flush();
  return kept;
}

bool TickWindows::ArmOne(std::uint64_t last, double pulse_energy_mj,
                         const std::function<void(std::uint32_t point)>& late,
                         const PulseTrigger& trigger) {
  HeldWindow window;
  bool kept = true;
  window.arm = schedule_.Decide(
      decided_ + 1, last,
      [&](std::uint64_t tick, std::uint32_t point) { kept &= record_.Arm(tick, point); },
      late);
  trigger.Mark(window.arm);
  window.arm.pulse_energy_mj = pulse_energy_mj;
  window.arm.pulses_per_point = pulses_per_point_;
  if (!kept || record_.disk_failed()) return false;
  window.journal_number = record_.appended();
  held_.push_back(std::move(window));
  decided_ = last;
  return true;
}

void TickWindows::SendDurable() {
  while (!held_.empty() && held_.front().journal_number <= record_.durable()) {
    const link::ArmWindow& arm = held_.front().arm;
    if (!laser_.CanSend() || !laser_.Arm(arm)) return;
    sent_through_ = arm.first_tick + arm.fire.size() - 1;
    held_.pop_front();
  }
}

void TickWindows::SendIdle(std::size_t count) {
  const link::LaserStatus& status = laser_.status();
  // In a safe state or another session it has forgotten what was decided.
  const bool forgotten = session_lost() || laser_.Has(link::kSafeState);
  decided_ = std::max({forgotten ? 0 : decided_, status.decided_through, status.tick});
  session_ = laser_.session();
  if (laser_.Has(link::kSafeState) || decided_ > status.tick) return;
  link::ArmWindow idle{decided_ + 1, true, std::vector<bool>(count, false)};
  if (!laser_.Arm(idle)) return;
  decided_ += idle.fire.size();
  (void)laser_.RequestStatus();
}

void TickWindows::Receive(const link::PulseReport& report) {
  if (report.outcome.empty()) return;
  reported_through_ =
      std::max(reported_through_, report.first_tick + report.outcome.size() - 1);
  schedule_.Apply(report, [this](const PulseResult& r) { Resolve(r); });
}

void TickWindows::Receive(const link::PastReport& report) {
  schedule_.Apply(report, [this](const PulseResult& r) { Resolve(r); });
}

void TickWindows::Resolve(const PulseResult& result) {
  if (result.tick <= certain_through_) return record_.Resolve(result);
  if (formats::IsFired(result.outcome)) {
    unplaced_.push_back(result);
    if (lost_places_) LosePlaces();
  } else {
    others_.push_back(result);
    record_.Resolve(result);
  }
}

void TickWindows::SetCertain(std::uint64_t through, double late_ticks) {
  certain_through_ = through;
  late_ticks_ = late_ticks;
  std::erase_if(others_, [&](const auto& other) { return other.tick <= through; });
  for (const PulseResult& result : std::exchange(unplaced_, {})) Resolve(result);
}

void TickWindows::LosePlaces() {
  lost_places_ = true;
  for (const PulseResult& result : std::exchange(unplaced_, {})) {
    last_unplaced_ = std::max(last_unplaced_, result.tick);
    record_.Resolve({result.tick, result.point, formats::PointOutcome::kUncertain,
                     SkipReason::kPosition});
  }
  MarkHit();
}

// In position is on for a quarter of a tick around that of a point.
void TickWindows::MarkHit() {
  constexpr double kInPositionTicks = 0.25;
  const auto hit_later =
      static_cast<std::uint64_t>(std::ceil(late_ticks_ + kInPositionTicks));
  marks_owed_ = false;
  for (const PulseResult& other : others_) {
    const PointState state = record_.ledger().state(other.point);
    const bool open = state == PointState::kPlanned || state == PointState::kSkipped;
    const bool hit = last_unplaced_ > 0 && other.tick <= last_unplaced_ + hit_later;
    if (!open || !hit) continue;
    marks_owed_ |= !record_.MarkUncertain(other.point, SkipReason::kPosition);
  }
  // What is opened again by consent is not marked again.
  if (schedule_.empty() && !marks_owed_) others_.clear();
}

std::vector<PulseResult> TickWindows::DropUnsent() {
  const auto open = schedule_.OpenAfter(certain_through_);
  others_.insert(others_.end(), open.begin(), open.end());
  schedule_.DropUnarmed();
  held_.clear();
  return schedule_.ArmedWithin(sent_through_ + 1, UINT64_MAX);
}

}  // namespace intaglio::synchronizer
