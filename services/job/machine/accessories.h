#pragma once

// Outputs and inputs of a machine for other uses, as bits of its laser controller's: bit
// 0 is number 1. Profiles are checked (services/job/checks/accessory_check.h).

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "proto/machine.pb.h"

namespace intaglio {

/// `number`: from 1 to 8.
constexpr std::uint8_t AccessoryBit(std::uint32_t number) {
  return static_cast<std::uint8_t>(1u << (number - 1));
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
  std::vector<bool> inputs;
  for (const MachineInput& input : machine.inputs()) {
    if (inputs.size() < input.input()) inputs.resize(input.input());
    inputs[input.input() - 1] = input.state() == INPUT_ON;
  }
  return inputs;
}

}  // namespace intaglio
