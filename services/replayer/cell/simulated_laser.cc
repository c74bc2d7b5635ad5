#include "services/replayer/cell/simulated_laser.h"

#include <algorithm>

#include "engrave/core/try.h"

namespace intaglio::replayer {
namespace {

using link::LaserFrame;

// As the machine's.
constexpr int kTicksAtOnce = 2048;

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
  // At any of its wavelengths: the synchronizer has checked the energy of the job's.
  options.max_energy_mj = machine.laser().pulse_energy_mj();
  for (const LaserWavelength& further : machine.laser().further_wavelengths())
    options.max_energy_mj = std::max(options.max_energy_mj, further.pulse_energy_mj());
  options.energy_spread_ratio = 0;
  options.locks_door = machine.laser().door_lock();
  options.output_count = link::kMaxAccessories;
  options.inputs.assign(link::kMaxAccessories, true);
  for (const MachineInput& input : machine.inputs()) {
    if (input.input() >= 1 && input.input() <= options.inputs.size())
      options.inputs[input.input() - 1] = input.state() == INPUT_ON;
  }
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
    : line_(std::move(line)), laser_(std::move(options)) {
  end_.Plug(line_.MachineEnd(), link::MonotonicClock());
}

void SimulatedLaser::Turn(std::chrono::nanoseconds now, const EndOfPulse& end_of_pulse) {
  PollLine();
  int passed = 0;
  while (passed < kTicksAtOnce && !end_.line().is_full() && PassTick(end_of_pulse)) {
    ++passed;
  }
  end_.SendOutcomes();
  end_.SendStatus(now, passed > 0, virtual_engraver::kStatusPeriod);
  end_.line().Flush();
  PollLine();
}

void SimulatedLaser::PollLine() {
  if (end_.Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
        Note(static_cast<LaserFrame>(type), payload);
      })) {
    armed_.clear();
  }
}

void SimulatedLaser::Note(LaserFrame type, std::span<const std::byte> payload) {
  if (type == LaserFrame::kDisarm) armed_.clear();
  if (type != LaserFrame::kArmWindow) return;
  const auto m = link::Decode<link::ArmWindow>(payload);
  if (!m) return;
  for (std::size_t i = 0; i < m->fire.size(); ++i) {
    const std::uint64_t tick = m->first_tick + i;
    if (m->fire[i] && tick > laser_.tick()) armed_.push_back(tick);
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

}  // namespace intaglio::replayer
