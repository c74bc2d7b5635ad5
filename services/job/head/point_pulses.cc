#include "services/job/head/point_pulses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "proto/job.pb.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {

std::uint32_t PulsesOfDwell(const MachineSpec& machine) {
  const JumpAndDwell& jumps = machine.head_over_block().jump_and_dwell();
  const double pulses = jumps.dwell_s() * machine.bjjcz_board().point_frequency_hz();
  const double max_pulses =
      RangeOf<LaserOptions>(LaserOptions::kPulsesPerPointFieldNumber).max;
  return static_cast<std::uint32_t>(std::clamp(std::round(pulses), 1.0, max_pulses));
}

double DwellSecondsOf(const MachineSpec& machine, std::uint32_t pulses) {
  const double frequency_hz = machine.bjjcz_board().point_frequency_hz();
  // What a profile has in its dwell is made as long as the profile has it.
  if (!(frequency_hz > 0) || pulses == PulsesOfDwell(machine))
    return machine.head_over_block().jump_and_dwell().dwell_s();
  return pulses / frequency_hz;
}

double LongestPointSeconds(const MachineSpec& machine, double dwell_s) {
  const JumpAndDwell& jumps = machine.head_over_block().jump_and_dwell();
  return std::sqrt(2) * machine.scan_head().field_mm() / jumps.jump_mm_s() +
         jumps.jump_delay_s() + dwell_s;
}

std::string WhyNotSoManyPulses(const MachineSpec& machine, std::uint32_t pulses) {
  const double frequency_hz = machine.bjjcz_board().point_frequency_hz();
  if (!machine.head_over_block().has_jump_and_dwell() || !(frequency_hz > 0)) {
    if (pulses <= 1) return "";
    return fmt::format(
        "is of a head with head_over_block.jump_and_dwell and "
        "bjjcz_board.point_frequency_hz, and {} makes a point by one pulse; remove it",
        machine.name());
  }
  constexpr double kDwellStep_s = 1e-5;
  const double dwell_s = DwellSecondsOf(machine, pulses);
  const double made_s = kDwellStep_s * std::max(1.0, std::round(dwell_s / kDwellStep_s));
  if (std::abs(made_s * frequency_hz - pulses) >= 0.5 &&
      pulses != PulsesOfDwell(machine)) {
    return fmt::format(
        "take {:.3g} us at {:g} Hz, and the board dwells for whole tens of microseconds; "
        "ask for a multiple of {:g}",
        1e6 * dwell_s, frequency_hz, std::ceil(frequency_hz * kDwellStep_s));
  }
  if (const double point_s = LongestPointSeconds(machine, dwell_s);
      point_s > kMaxBoardPointSeconds) {
    return fmt::format(
        "take {:.3f} s with a jump across the field, at most {:g} s is possible, since "
        "the board ends what it has without a host; ask for fewer",
        point_s, kMaxBoardPointSeconds);
  }
  return "";
}

}  // namespace intaglio
