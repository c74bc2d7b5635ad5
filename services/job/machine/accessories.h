#pragma once

// Outputs and inputs of a machine for other uses, as bits of its laser controller's: bit
// 0 is number 1. Profiles are checked (services/job/checks/accessory_check.h).

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "proto/machine.pb.h"

namespace intaglio {

/// `number`: from 1 to 8; another one, of a profile that is not checked, has none.
constexpr std::uint8_t AccessoryBit(std::uint32_t number) {
  return number < 1 || number > 8 ? std::uint8_t{0}
                                  : static_cast<std::uint8_t>(1u << (number - 1));
}

/// Those that are on while an arm holds; `engraves`: and points are made by it.
inline std::uint8_t OutputsUnderArm(const MachineSpec& machine, bool engraves) {
  unsigned on = 0;
  for (const MachineOutput& output : machine.outputs()) {
    if (engraves || output.on() == OUTPUT_WHILE_ARMED)
      on |= AccessoryBit(output.output());
  }
  return static_cast<std::uint8_t>(on);
}

struct NeededInputs {
  std::uint8_t watched = 0;  ///< that the profile names
  std::uint8_t levels = 0;   ///< among these: that have to be on
};

inline NeededInputs NeededInputsOf(const MachineSpec& machine) {
  unsigned watched = 0, levels = 0;
  for (const MachineInput& input : machine.inputs()) {
    watched |= AccessoryBit(input.input());
    if (input.state() == INPUT_ON) levels |= AccessoryBit(input.input());
  }
  return {static_cast<std::uint8_t>(watched), static_cast<std::uint8_t>(levels)};
}

/// As many as a controller needs for the profile.
inline std::uint32_t OutputCountOf(const MachineSpec& machine) {
  std::uint32_t count = 0;
  for (const MachineOutput& output : machine.outputs())
    count = std::max(count, output.output());
  return count;
}

/// The inputs of a controller for the profile, each on that has to be on.
inline std::vector<bool> InputsAsNeeded(const MachineSpec& machine) {
  const NeededInputs needed = NeededInputsOf(machine);
  std::vector<bool> inputs(static_cast<std::size_t>(std::bit_width(needed.watched)));
  for (std::size_t i = 0; i < inputs.size(); ++i)
    inputs[i] = (needed.levels >> i & 1) != 0;
  return inputs;
}

}  // namespace intaglio
