#include "services/virtual_engraver/laser.h"

#include <algorithm>
#include <utility>

namespace intaglio::virtual_engraver {

using link::LaserFrame;
using link::TickOutcome;

Laser::Laser(LaserOptions options)
    : options_(std::move(options)),
      rate_hz_(options_.rates_hz.front()),
      next_rate_hz_(rate_hz_),
      accessories_(options_.output_count, options_.inputs),
      random_(options_.seed) {}

void Laser::SetLamp(const link::LampCommand& command) {
  if (!command.on || !lamp_on_) lamp_s_ = 0;
  lamp_on_ = command.on;
  const auto& rates = options_.rates_hz;
  if (std::find(rates.begin(), rates.end(), command.rate_hz) != rates.end()) {
    next_rate_hz_ = command.rate_hz;
  }
}

bool Laser::Obey(LaserFrame type, std::span<const std::byte> payload) {
  switch (type) {
    case LaserFrame::kLampCommand:
      if (const auto m = link::Decode<link::LampCommand>(payload)) SetLamp(*m);
      return true;
    case LaserFrame::kShutterCommand:
      if (const auto m = link::Decode<link::ShutterCommand>(payload)) {
        SetShutters(m->open_mask);
      }
      return true;
    case LaserFrame::kPulseTiming:
      if (const auto m = link::Decode<link::PulseTiming>(payload)) SetTiming(*m);
      return true;
    case LaserFrame::kAccessoryCommand:
      if (const auto m = link::Decode<link::AccessoryCommand>(payload)) Command(*m);
      return true;
    case LaserFrame::kArmWindow:
      if (const auto m = link::Decode<link::ArmWindow>(payload)) Decide(*m);
      return true;
    case LaserFrame::kDisarm:
      Disarm();
      return true;
    case LaserFrame::kLaserStop:
      Stop();
      return true;
    case LaserFrame::kLaserReset:
      Reset();
      return true;
    default:
      return false;
  }
}

void Laser::SetShutters(std::uint8_t open_mask) {
  const auto built_in = static_cast<std::uint8_t>((1u << options_.channels) - 1);
  MoveShutters(safe_state_ ? std::uint8_t{0}
                           : static_cast<std::uint8_t>(open_mask & built_in));
}

// A command comes within the present tick, whose time is known at its end.
void Laser::MoveShutters(std::uint8_t open_mask) {
  if (open_mask == shutters_) return;
  shutters_before_ = shutters_;
  shutters_ = open_mask;
  shutters_moved_s_ = machine_s_ + 1 / rate_hz_;
}

void Laser::Command(const link::AccessoryCommand& command) {
  accessories_.Watch(command);
  CheckInputs();
  accessories_.Switch(interlocked() ? std::uint8_t{0} : command.on);
}

void Laser::Decide(const link::ArmWindow& window) {
  // Beyond the end of the count there are no ticks.
  if (window.fire.empty() || window.first_tick + window.fire.size() < window.first_tick)
    return;
  const std::uint64_t last = window.first_tick + window.fire.size() - 1;
  const std::uint64_t open_from = std::max(tick_, decided_through_) + 1;
  for (std::uint64_t t = window.first_tick; t <= last && t < open_from; ++t) {
    if (window.fire[t - window.first_tick]) {
      reports_.push_back({t, {TickOutcome::kTooLate}});
    }
  }
  if (last < open_from || safe_state_) return;
  windows_.push_back(window);
  decided_through_ = last;
}

void Laser::Disarm() {
  ++disarms_taken_;
  windows_.clear();
  decided_through_ = std::min(decided_through_, tick_);
}

void Laser::Reset() {
  if (stop_released_) stop_latched_ = false;
  if (!stop_latched_) safe_state_ = false;
}

void Laser::NewSession() {
  Disarm();
  accessories_.SwitchOff();
  disarms_taken_ = 0;
  reports_.clear();
}

void Laser::Set(bool& holds, bool now) {
  if (holds && !now) {
    ++openings_;
    accessories_.SwitchOff();
  }
  holds = now;
}

void Laser::SetStopButton(bool pressed) {
  Set(stop_released_, !pressed);
  if (pressed) Stop();
}

void Laser::EnterSafeState() {
  safe_state_ = true;
  MoveShutters(0);
  accessories_.SwitchOff();
  windows_.clear();
  decided_through_ = std::min(decided_through_, tick_);
}

bool Laser::interlocked() const {
  return !key_on_ || !door_closed_ || !stop_released_ || !inputs_hold_ || stop_latched_ ||
         safe_state_;
}

bool Laser::door_locked() const {
  if (!options_.locks_door || lock_broken_ || !door_closed_) return false;
  const double time_s =
      std::max(options_.signals.shutter_time_s, timing_.shutter_time_ms / 1000);
  const bool closing = shutters_before_ != 0 && time_s > 0 && ShuttersMove(time_s);
  return shutters_ != 0 || closing;
}

TickOutcome Laser::OutcomeAt(bool armed, const link::ArmWindow& window,
                             bool in_position) const {
  if (!armed) return TickOutcome::kNotArmed;
  if (window.gated && !in_position) return TickOutcome::kNotInPosition;
  if (window.at_place && !options_.fires_at_place) return TickOutcome::kNotInPosition;
  if (interlocked()) return TickOutcome::kInterlocked;
  if (!lamp_on_ || lamp_s_ < options_.warm_up_s) return TickOutcome::kLampNotReady;
  if (shutters_ == 0) return TickOutcome::kShutterClosed;
  if (timing_.shutter_time_ms > 0 && ShuttersMove(timing_.shutter_time_ms / 1000))
    return TickOutcome::kShutterClosed;
  if (options_.locks_door && !door_locked()) return TickOutcome::kInterlocked;
  if (!TakesTrigger(options_.signals, timing_, window.at_place))
    return TickOutcome::kTriggerOutside;
  // false for NaN
  const double energy_mj = window.pulse_energy_mj;
  if (!(energy_mj >= options_.min_energy_mj && energy_mj <= options_.max_energy_mj))
    return TickOutcome::kEnergyOutside;
  return TickOutcome::kFiredSeen;  // Missed() takes it back
}

bool Laser::NextFiresAtPlace() const {
  const std::uint64_t next = tick_ + 1;
  for (const link::ArmWindow& window : windows_) {
    if (next < window.first_tick) return false;
    const std::uint64_t i = next - window.first_tick;
    if (i < window.fire.size()) return window.at_place && window.fire[i];
  }
  return false;
}

std::uint8_t Laser::AdvanceTick(bool in_position, double late_s) {
  ++tick_;
  past_[tick_ % past_.size()] = TickOutcome::kNotArmed;
  past_missed_[tick_ % past_.size()] = 0;
  const double period_s = 1 / rate_hz_ + late_s;
  machine_s_ += period_s;
  if (lamp_on_) lamp_s_ += period_s;
  rate_hz_ = next_rate_hz_;
  while (!windows_.empty() &&
         windows_.front().first_tick + windows_.front().fire.size() <= tick_) {
    windows_.pop_front();
  }
  if (windows_.empty() || windows_.front().first_tick > tick_) return 0;
  const link::ArmWindow& window = windows_.front();
  const TickOutcome outcome =
      OutcomeAt(window.fire[tick_ - window.first_tick], window, in_position);
  Note(tick_, outcome);
  if (outcome != TickOutcome::kFiredSeen) return 0;
  ++pulse_count_;
  pulses_of_point_ = std::max<std::uint16_t>(1, window.pulses_per_point);
  made_pulse_count_ += pulses_of_point_;
  fired_before_tick_ = std::exchange(last_fired_tick_, tick_);
  Discharge(window.pulse_energy_mj);
  // A shutter on its way lets a part of the beam pass.
  const double time_s = options_.signals.shutter_time_s;
  pulse_channels_ = time_s > 0 && ShuttersMove(time_s)
                        ? static_cast<std::uint8_t>(shutters_ | shutters_before_)
                        : shutters_;
  if (options_.signals.sensor_width_us <= timing_.min_sensor_width_us)
    Missed(pulse_channels_);
  return pulse_channels_;
}

void Laser::Withhold() {
  --pulse_count_;
  made_pulse_count_ -= pulses_of_point_;
  last_fired_tick_ = fired_before_tick_;
  reports_.back().outcome.back() = TickOutcome::kTriggerOutside;
  reports_.back().missed.back() = 0;
  reports_.back().measured_mj.back() = 0;
  past_[tick_ % past_.size()] = TickOutcome::kTriggerOutside;
  past_missed_[tick_ % past_.size()] = 0;
}

void Laser::Discharge(double energy_mj) {
  // The same numbers from every standard library.
  const double uniform = static_cast<double>(random_() >> 11) * 0x1p-53;
  pulse_energy_mj_ = energy_mj * (1 + options_.energy_error_ratio) *
                     (1 + options_.energy_spread_ratio * (2 * uniform - 1));
  if (options_.measures_energy)
    reports_.back().measured_mj.back() = static_cast<float>(pulse_energy_mj_);
}

void Laser::Missed(std::uint8_t channels) {
  const auto missed = static_cast<std::uint8_t>(channels & pulse_channels_);
  if (missed == 0) return;
  reports_.back().outcome.back() = TickOutcome::kFiredUnseen;
  reports_.back().missed.back() |= missed;
  past_[tick_ % past_.size()] = TickOutcome::kFiredUnseen;
  past_missed_[tick_ % past_.size()] |= missed;
}

void Laser::Unseen() {
  reports_.back().outcome.back() = TickOutcome::kFiredUnseen;
  past_[tick_ % past_.size()] = TickOutcome::kFiredUnseen;
}

void Laser::Note(std::uint64_t tick, TickOutcome outcome) {
  const bool follows =
      !reports_.empty() && reports_.back().outcome.back() != TickOutcome::kTooLate &&
      reports_.back().first_tick + reports_.back().outcome.size() == tick &&
      reports_.back().outcome.size() < link::kMaxReportTicks;
  if (!follows) reports_.push_back({tick, {}});
  reports_.back().outcome.push_back(outcome);
  reports_.back().missed.push_back(0);
  reports_.back().measured_mj.push_back(0);
  past_[tick % past_.size()] = outcome;
}

std::vector<link::PulseReport> Laser::TakeReports() {
  return std::exchange(reports_, {});
}

link::PastReport Laser::Past(const link::PastRequest& asked) const {
  link::PastReport report{asked.first_tick, {}};
  for (std::uint64_t i = 0; i < asked.count; ++i) {
    const std::uint64_t tick = asked.first_tick + i;
    if (tick > tick_) {
      report.outcome.push_back(TickOutcome::kNotArmed);
      report.missed.push_back(0);
    } else if (tick_ - tick >= past_.size()) {
      report.outcome.push_back(TickOutcome::kNoLongerKnown);
      report.missed.push_back(0);
    } else {
      report.outcome.push_back(past_[tick % past_.size()]);
      report.missed.push_back(past_missed_[tick % past_.size()]);
    }
  }
  return report;
}

link::LaserStatus Laser::Report() const {
  link::LaserStatus status;
  status.tick = tick_;
  status.machine_us = static_cast<std::uint64_t>(machine_s_ * 1e6);
  status.rate_hz = rate_hz_;
  status.warm_ratio = !lamp_on_ ? 0
                      : options_.warm_up_s <= 0
                          ? 1
                          : std::min(1.0, lamp_s_ / options_.warm_up_s);
  const auto set = [&status](bool on, link::InterlockBits bit) {
    if (on) status.interlocks = static_cast<std::uint8_t>(status.interlocks | bit);
  };
  set(key_on_, link::kKeyOn);
  set(door_closed_, link::kDoorClosed);
  set(stop_released_ && !stop_latched_, link::kStopReleased);
  set(lamp_on_, link::kLampOn);
  set(lamp_on_ && lamp_s_ >= options_.warm_up_s, link::kLampWarm);
  set(safe_state_, link::kSafeState);
  set(!CountsSync(), link::kNoLampSync);
  set(door_locked(), link::kDoorLocked);
  const bool moving =
      timing_.shutter_time_ms > 0 && ShuttersMove(timing_.shutter_time_ms / 1000);
  status.shutters_open = moving ? shutters_before_ : shutters_;
  status.pulse_count = pulse_count_;
  status.last_fired_tick = last_fired_tick_;
  status.decided_through = decided_through_;
  status.disarms_taken = disarms_taken_;
  status.openings = openings_;
  return status;
}

link::LaserIdentity Laser::Identity() const {
  return {options_.power_up,       options_.lockstep,      options_.channels,
          options_.rates_hz,       options_.model,         options_.serial_number,
          options_.fires_at_place, options_.min_energy_mj, options_.max_energy_mj,
          options_.locks_door};
}

}  // namespace intaglio::virtual_engraver
