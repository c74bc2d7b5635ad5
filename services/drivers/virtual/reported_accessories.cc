#include "services/drivers/virtual/reported_accessories.h"

#include <fmt/format.h>

#include "services/job/machine/accessories.h"

namespace intaglio::drivers {
namespace {

std::string Absent(const char* kind, const std::string& name, std::uint32_t number,
                   std::uint32_t count) {
  return fmt::format(
      "the laser controller has {1} {0}s, and '{2}' of the machine profile is {0} {3}: "
      "connect it to one that the controller has, or remove it from {0}s of the profile",
      kind, count, name, number);
}

std::string NamesOfOn(const MachineSpec& machine, const link::AccessoryState& state) {
  std::string names;
  for (const MachineOutput& output : machine.outputs()) {
    if ((state.on & AccessoryBit(output.output())) == 0) continue;
    names += (names.empty() ? "" : ", ") + output.name();
  }
  return names;
}

std::string OpenInput(const MachineSpec& machine, const link::AccessoryState& state) {
  for (const MachineOutput& output : machine.outputs()) {
    if (output.output() > state.output_count)
      return Absent("output", output.name(), output.output(), state.output_count);
  }
  std::string open;
  for (const MachineInput& input : machine.inputs()) {
    if (input.input() > state.input_count)
      return Absent("input", input.name(), input.input(), state.input_count);
    const bool on = (state.levels & AccessoryBit(input.input())) != 0;
    if (on == (input.state() == INPUT_ON)) continue;
    open += fmt::format("{}the input '{}' is {}: {}", open.empty() ? "" : "; ",
                        input.name(), on ? "on" : "off", input.remedy());
  }
  return open;
}

}  // namespace

Accessories ReportedAccessories(const MachineSpec& machine,
                                const link::AccessoryState& state) {
  return {state.on, NamesOfOn(machine, state), OpenInput(machine, state)};
}

}  // namespace intaglio::drivers
