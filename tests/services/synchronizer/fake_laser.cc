#include "tests/services/synchronizer/fake_laser.h"

#include <algorithm>

namespace intaglio::synchronizer {

using link::LaserFrame;
using link::TickOutcome;
using namespace std::chrono_literals;

void FakeLaser::Plug(std::unique_ptr<link::ByteStream> end) {
  link::LinkOptions options;
  options.waits = waits;
  line_ = std::make_unique<link::ReliableLink>(link::Side::kDevice, std::move(end),
                                               clock_, options, epoch_);
  session_ = 0;
  waiting_.clear();
}

void FakeLaser::PowerCycle(std::unique_ptr<link::ByteStream> end) {
  ++power_up_;
  tick_ = decided_through_ = pulse_count_ = last_fired_tick_ = 0;
  openings = 0;
  lamp_on_ = safe_ = stop_latched_ = false;
  shutters_ = shutters_asked_ = 0;
  decided_.clear();
  outcomes_.clear();
  past_.clear();
  *epoch_ = {};
  Plug(std::move(end));
}

void FakeLaser::Poll() {
  const bool shut = key_on && door_closed && !stop_pressed_ && inputs_hold();
  if (was_shut_ && !shut) ++openings;
  was_shut_ = shut;
  const auto receive = [this](std::uint8_t type, std::span<const std::byte> payload) {
    Receive(static_cast<LaserFrame>(type), payload);
  };
  (void)line_->Poll(receive);
  MoveShutters();
  if (line_->up() && line_->session() != session_) {
    session_ = line_->session();
    Disarm();
    disarms_taken_ = 0;
    outcomes_.clear();
    waiting_.clear();
    commanded_.on = 0;
    sent_accessories_ = {};
    Send(LaserFrame::kLaserIdentity, Encode(link::LaserIdentity{power_up_,
                                                                lockstep_,
                                                                4,
                                                                {kRateHz},
                                                                "test",
                                                                serial_number,
                                                                false,
                                                                min_energy_mj,
                                                                max_energy_mj,
                                                                locks_door}));
  }
  if (!line_->up() && (shutters_ != 0 || !decided_.empty())) EnterSafeState();
  SendStatus();
  (void)line_->Poll(receive);
}

void FakeLaser::Receive(LaserFrame type, std::span<const std::byte> payload) {
  received.push_back(type);
  switch (type) {
    case LaserFrame::kLampCommand: {
      const bool on = link::Decode<link::LampCommand>(payload)->on;
      if (on && !lamp_on_) {
        lamp_s_ = 0;
        ++lamp_switched_on_count_;
      }
      lamp_on_ = on;
      return;
    }
    case LaserFrame::kShutterCommand:
      AskShutters(link::Decode<link::ShutterCommand>(payload)->open_mask);
      return MoveShutters();
    case LaserFrame::kArmWindow:
      return Decide(*link::Decode<link::ArmWindow>(payload));
    case LaserFrame::kDisarm:
      return Disarm();
    case LaserFrame::kLaserStop:
      stop_latched_ = true;
      return EnterSafeState();
    case LaserFrame::kLaserReset:
      if (!stop_pressed_) stop_latched_ = safe_ = false;
      return;
    case LaserFrame::kAccessoryCommand:
      commanded_ = *link::Decode<link::AccessoryCommand>(payload);
      if (safe_) commanded_.on = 0;
      return;
    case LaserFrame::kLaserStatusRequest:
      status_asked_ = true;
      return;
    case LaserFrame::kPastRequest:
      return Send(LaserFrame::kPastReport,
                  Encode(Past(*link::Decode<link::PastRequest>(payload))));
    default:
      return;
  }
}

void FakeLaser::Decide(const link::ArmWindow& window) {
  for (std::size_t i = 0; i < window.fire.size(); ++i) {
    const std::uint64_t tick = window.first_tick + i;
    if (window.fire[i]) {
      newest_arm_at_ = clock_();
      if (on_arm) on_arm(tick);
    }
    if (tick <= std::max(tick_, decided_through_)) {
      if (window.fire[i]) {
        SendReports();
        Send(LaserFrame::kPulseReport,
             Encode(link::PulseReport{tick, {TickOutcome::kTooLate}}));
      }
    } else if (!safe_) {
      decided_[tick] = {window.fire[i], window.gated, window.pulse_energy_mj};
    }
  }
  if (!decided_.empty()) {
    decided_through_ = std::max(decided_through_, decided_.rbegin()->first);
  }
}

void FakeLaser::Disarm() {
  ++disarms_taken_;
  decided_.clear();
  decided_through_ = std::min(decided_through_, tick_);
}

void FakeLaser::EnterSafeState() {
  safe_ = true;
  commanded_.on = 0;
  shutters_ = shutters_asked_ = 0;
  decided_.clear();
  decided_through_ = std::min(decided_through_, tick_);
}

// The same again does not begin the movement anew.
void FakeLaser::AskShutters(std::uint8_t open_mask) {
  if (safe_) open_mask = 0;
  if (open_mask != 0) ++shutters_asked_count_;
  if (open_mask != shutters_asked_) shutters_move_at_ = clock_() + shutter_travel;
  shutters_asked_ = open_mask;
}

void FakeLaser::MoveShutters() {
  if (clock_() >= shutters_move_at_) shutters_ = shutters_asked_;
}

void FakeLaser::PressStop(bool pressed) {
  stop_pressed_ = pressed;
  if (!pressed) return;
  stop_latched_ = true;
  EnterSafeState();
}

TickOutcome FakeLaser::OutcomeAt(const Decision& decision, bool in_position) const {
  if (!decision.fire) return TickOutcome::kNotArmed;
  if (decision.gated && !in_position) return TickOutcome::kNotInPosition;
  if (!key_on || !door_closed || stop_pressed_ || stop_latched_ || safe_ ||
      !inputs_hold())
    return TickOutcome::kInterlocked;
  if (!warm()) return TickOutcome::kLampNotReady;
  if (OpenNow() == 0) return TickOutcome::kShutterClosed;
  if (trigger_late) return TickOutcome::kTriggerOutside;
  if (refuses_energy) return TickOutcome::kEnergyOutside;
  return blind ? TickOutcome::kFiredUnseen : TickOutcome::kFiredSeen;
}

void FakeLaser::AdvanceTick(bool in_position, const Vec3& at_mm) {
  ++tick_;
  if (burns()) lamp_s_ += 1 / kRateHz;
  if (!burns()) lamp_s_ = 0;
  const auto found = decided_.find(tick_);
  if (found == decided_.end()) return;
  const TickOutcome outcome = OutcomeAt(found->second, in_position);
  const double energy_mj = found->second.energy_mj;
  decided_.erase(found);
  outcomes_.emplace_back(tick_, outcome);
  past_[tick_] = outcome;
  if (outcome != TickOutcome::kFiredSeen && outcome != TickOutcome::kFiredUnseen) return;
  ++pulse_count_;
  last_fired_tick_ = tick_;
  newest_pulse_at_ = clock_();
  cracks_.push_back({power_up_, tick_, at_mm, !blind, OpenNow(), energy_mj});
}

link::PastReport FakeLaser::Past(const link::PastRequest& asked) const {
  link::PastReport report{asked.first_tick, {}};
  for (std::uint64_t t = asked.first_tick; t < asked.first_tick + asked.count; ++t) {
    const auto found = past_.find(t);
    const bool lost = t <= tick_ && (forgets || t + link::kRememberedTicks <= tick_);
    report.outcome.push_back(lost                   ? TickOutcome::kNoLongerKnown
                             : found == past_.end() ? TickOutcome::kNotArmed
                                                    : found->second);
  }
  return report;
}

void FakeLaser::Send(LaserFrame type, link::Bytes payload) {
  waiting_.emplace_back(type, std::move(payload));
}

void FakeLaser::SendReports() {
  for (std::size_t i = 0; i < outcomes_.size();) {
    link::PulseReport report{outcomes_[i].first, {}};
    while (i < outcomes_.size() && report.outcome.size() < link::kMaxReportTicks &&
           outcomes_[i].first == report.first_tick + report.outcome.size()) {
      const bool unseen = outcomes_[i].second == TickOutcome::kFiredUnseen;
      report.outcome.push_back(outcomes_[i++].second);
      report.missed.push_back(unseen ? missed_channels : std::uint8_t{0});
      report.measured_mj.push_back(measured_mj);
    }
    Send(LaserFrame::kPulseReport, Encode(report));
  }
  outcomes_.clear();
}

void FakeLaser::SendAccessories() {
  if (!inputs_hold()) commanded_.on = 0;
  const link::AccessoryState state{
      output_count, input_count, commanded_.on,
      static_cast<std::uint8_t>(input_levels & ((1u << input_count) - 1))};
  if (state == sent_accessories_) return;
  sent_accessories_ = state;
  Send(LaserFrame::kAccessoryState, Encode(state));
}

void FakeLaser::SendStatus() {
  const link::LaserStatus status = Status();
  const std::uint32_t state = status.interlocks | status.shutters_open << 8;
  if (mute || !line_->up()) return;
  SendAccessories();
  SendReports();
  if (status_asked_ || state != sent_state_ || clock_() >= next_status_) {
    status_asked_ = false;
    sent_state_ = state;
    next_status_ = clock_() + 20ms;
    Send(LaserFrame::kLaserStatus, Encode(status));
  }
  while (!waiting_.empty() && line_->CanSend()) {
    const auto& [type, payload] = waiting_.front();
    if (!line_->Send(static_cast<std::uint8_t>(type), payload)) return;
    waiting_.pop_front();
  }
}

link::LaserStatus FakeLaser::Status() const {
  link::LaserStatus status;
  status.tick = tick_;
  status.machine_us = static_cast<std::uint64_t>(1e6 * tick_ / kRateHz);
  status.rate_hz = kRateHz;
  status.warm_ratio = burns() ? std::min(1.0, lamp_s_ / kWarmUpS) : 0;
  const std::pair<bool, link::InterlockBits> bits[] = {
      {key_on, link::kKeyOn},
      {door_closed, link::kDoorClosed},
      {!stop_pressed_ && !stop_latched_, link::kStopReleased},
      {burns(), link::kLampOn},
      {warm(), link::kLampWarm},
      {short_sync, link::kNoLampSync},
      {locks_door && !lock_broken && door_closed && OpenNow() != 0, link::kDoorLocked},
      {safe_, link::kSafeState}};
  for (const auto& [on, bit] : bits) {
    if (on) status.interlocks = static_cast<std::uint8_t>(status.interlocks | bit);
  }
  status.shutters_open = OpenNow();
  status.pulse_count = pulse_count_;
  status.last_fired_tick = last_fired_tick_;
  status.decided_through = decided_through_;
  status.disarms_taken = disarms_taken_;
  status.openings = openings;
  return status;
}

}  // namespace intaglio::synchronizer
