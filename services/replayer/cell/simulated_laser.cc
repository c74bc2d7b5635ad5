#include "services/replayer/cell/simulated_laser.h"

#include <algorithm>

#include "engrave/core/try.h"
#include "services/platform/link/line_session.h"

namespace intaglio::replayer {
namespace {

using link::LaserFrame;
using namespace std::chrono_literals;

// As the machine's.
constexpr auto kStatusPeriod = 20ms;
constexpr int kTicksAtOnce = 2048;
constexpr std::size_t kMaxWaiting = 256;

virtual_engraver::LaserOptions OptionsOf(const MachineSpec& machine) {
  virtual_engraver::LaserOptions options;
  if (machine.laser().rates_hz_size() > 0) {
    options.rates_hz.assign(machine.laser().rates_hz().begin(),
                            machine.laser().rates_hz().end());
  }
  options.warm_up_s = 0;
  options.channels = static_cast<std::uint8_t>(
      std::clamp(static_cast<int>(machine.laser().channels()), 1, 4));
  options.lockstep = true;
  options.min_energy_mj = 0;
  options.max_energy_mj = machine.laser().pulse_energy_mj();
  options.energy_spread_ratio = 0;
  options.locks_door = machine.laser().door_lock();
  // The profile may name the one that the recorded cell had.
  options.serial_number = machine.laser_line().serial_number();
  return options;
}

}  // namespace

Result<std::unique_ptr<SimulatedLaser>> SimulatedLaser::Make(
    const std::filesystem::path& link, const MachineSpec& machine) {
  auto line = INTAGLIO_TRY(virtual_engraver::PtyLine::Open(link, "simulated laser"));
  return std::unique_ptr<SimulatedLaser>(
      new SimulatedLaser(std::move(line), OptionsOf(machine)));
}

SimulatedLaser::SimulatedLaser(virtual_engraver::PtyLine line,
                               virtual_engraver::LaserOptions options)
    : line_(std::move(line)),
      laser_(std::move(options)),
      link_(link::Side::kDevice, line_.MachineEnd(), link::MonotonicClock()) {}

void SimulatedLaser::Turn(std::chrono::nanoseconds now, const EndOfPulse& end_of_pulse) {
  PollLine();
  int passed = 0;
  while (passed < kTicksAtOnce && waiting_.size() < kMaxWaiting &&
         PassTick(end_of_pulse)) {
    ++passed;
  }
  SendReports(now, passed > 0);
  PollLine();
}

void SimulatedLaser::PollLine() {
  (void)link_.Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
    Take(static_cast<LaserFrame>(type), payload);
  });
  if (!link_.up() || link_.session() == session_) return;
  session_ = link_.session();
  waiting_.clear();
  armed_.clear();
  next_status_ = {};
  laser_.NewSession();
  Send(LaserFrame::kLaserIdentity, Encode(laser_.Identity()));
}

void SimulatedLaser::Note(std::span<const std::byte> window) {
  const auto m = link::Decode<link::ArmWindow>(window);
  if (!m) return;
  for (std::size_t i = 0; i < m->fire.size(); ++i) {
    const std::uint64_t tick = m->first_tick + i;
    if (m->fire[i] && tick > laser_.tick()) armed_.push_back(tick);
  }
}

void SimulatedLaser::Take(LaserFrame type, std::span<const std::byte> payload) {
  if (type == LaserFrame::kDisarm) armed_.clear();
  if (type == LaserFrame::kArmWindow) Note(payload);
  if (laser_.Obey(type, payload)) return;
  switch (type) {
    case LaserFrame::kLaserStatusRequest:
      status_asked_ = true;
      return;
    case LaserFrame::kPastRequest:
      if (const auto m = link::Decode<link::PastRequest>(payload))
        Send(LaserFrame::kPastReport, Encode(laser_.Past(*m)));
      return;
    default:
      return;
  }
}

bool SimulatedLaser::PassTick(const EndOfPulse& end_of_pulse) {
  if (!laser_.NextIsDecided()) return false;
  const std::uint64_t tick = laser_.tick() + 1;
  while (!armed_.empty() && armed_.front() < tick) armed_.pop_front();
  PulseEnd end = PulseEnd::kSeen;
  if (!armed_.empty() && armed_.front() == tick) {
    const auto known = end_of_pulse(armed_.size());
    if (!known) return false;
    end = *known;
    armed_.pop_front();
  }
  const std::uint8_t channels = laser_.AdvanceTick(end != PulseEnd::kNotInPosition);
  if (channels != 0 && end != PulseEnd::kSeen) laser_.Missed(channels);
  return true;
}

void SimulatedLaser::SendReports(std::chrono::nanoseconds now, bool at_once) {
  // Reports first: a status speaks of ticks whose outcomes are known already.
  for (const link::PulseReport& report : laser_.TakeReports())
    Send(LaserFrame::kPulseReport, Encode(report));
  const link::LaserStatus status = laser_.Report();
  const std::uint32_t interlocks = status.interlocks | status.shutters_open << 8;
  if (at_once || status_asked_ || interlocks != reported_ || now >= next_status_) {
    reported_ = interlocks;
    status_asked_ = false;
    next_status_ = now + kStatusPeriod;
    if (link_.up()) Send(LaserFrame::kLaserStatus, Encode(status));
  }
  while (!waiting_.empty() && link_.CanSend()) {
    const auto& [type, payload] = waiting_.front();
    if (!link_.Send(static_cast<std::uint8_t>(type), payload)) return;
    waiting_.pop_front();
  }
}

void SimulatedLaser::Send(LaserFrame type, link::Bytes payload) {
  waiting_.emplace_back(type, std::move(payload));
}

}  // namespace intaglio::replayer
