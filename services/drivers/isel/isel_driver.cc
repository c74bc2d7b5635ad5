#include "services/drivers/isel/isel_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::drivers {
namespace {

std::array<const AxisLimits*, 3> AxesOf(const MachineSpec& machine) {
  return {&machine.x(), &machine.y(), &machine.z()};
}

/// Why no controller is right for this profile; empty: it is whole.
std::string RefusalOf(const MachineSpec& machine) {
  if (!machine.motion_line().serial_number().empty()) {
    return "motion_line.serial_number: controllers of this family report none, so it "
           "cannot be compared: remove it";
  }
  if (machine.has_head_over_block()) {
    return "head_over_block: this family is driven with three linear axes alone: remove "
           "it";
  }
  if (machine.has_polar()) {
    return "polar: this family is driven with three linear axes alone: remove it";
  }
  const auto axes = AxesOf(machine);
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes[i]->steps_per_mm() > 0) continue;
    return fmt::format(
        "{}.steps_per_mm: is missing; this family counts in steps: give "
        "the steps of a turn of the motor over the screw's pitch",
        std::string(1, "xyz"[i]));
  }
  return "";
}

}  // namespace

IselDriver::IselDriver(const MachineSpec& machine, link::StreamOpener open,
                       link::SteadyClock clock)
    : LockstepDriver(machine, clock, "isel"),
      line_(std::move(open), std::move(clock), RefusalOf(machine)) {
  Vec3 steps_per_mm = Vec3::Ones();
  const auto axes = AxesOf(machine);
  for (int i = 0; i < 3; ++i) {
    const double steps = axes[static_cast<std::size_t>(i)]->steps_per_mm();
    if (steps > 0) steps_per_mm[i] = steps;
  }
  pieces_.SetTravel(TravelOf(machine));
  pieces_.SetStepsPerMm(steps_per_mm);
}

// No tick passes before the outcome of a pulse in it is known.
std::uint64_t IselDriver::LimitedByPulses(std::uint64_t tick) const {
  const bool waits = pulse_tick_ != 0 && ticks_.fires(pulse_tick_);
  return waits ? std::min(tick, pulse_tick_ - 1) : tick;
}

void IselDriver::EndRun() {
  end_mm_ = PlaceOf(place_);
  LockstepDriver::EndRun();
}

// A pulse that was sent is uncertain.
std::uint64_t IselDriver::ForgetSent() {
  move_.reset();
  is_checked_ = false;
  const std::uint64_t tick = std::exchange(pulse_tick_, 0);
  if (!std::exchange(is_fired_, false)) return 0;
  ticks_.Settle(tick, link::TickOutcome::kNoLongerKnown);
  return tick;
}

// The move that is executed ends at once; the output is off but in a pulse.
void IselDriver::StopController() {
  if (move_ || homing_) line_.SendStop();
}

Vec3 IselDriver::PlaceOf(const IselSteps& steps) const {
  return Vec3(steps[0], steps[1], steps[2]).array() / pieces_.steps_per_mm().array();
}

IselSteps IselDriver::StepsOf(const Vec3& place_mm) const {
  IselSteps steps{};
  for (int i = 0; i < 3; ++i) {
    const double wanted = std::round(place_mm[i] * pieces_.steps_per_mm()[i]);
    steps[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(
        std::clamp<double>(wanted, -kIselMaxSteps, kIselMaxSteps));
  }
  return steps;
}

Status IselDriver::AbortRun() {
  if (up() && !is_fired_) pulse_tick_ = 0;
  return LockstepDriver::AbortRun();
}

std::unique_ptr<MotionDriver> MakeIselDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock) {
  return std::make_unique<IselDriver>(machine, std::move(open), std::move(clock));
}

}  // namespace intaglio::drivers
