#include "services/cli/machine/machine_command.h"

namespace intaglio::cli {

void AddMachineCommand(command_line::Command app) {
  const command_line::Command machine = app.AddCommand(
      "machine", "the profile of a machine: make it, check it, measure it, compare it");
  machine.RequireCommand();
  machine.SetFooter("Example: intaglio machine check els-03");
  AddMachineNewCommand(machine);
  AddMachineCheckCommand(machine);
  AddMachineMeasureCommand(machine);
  AddMachineCompareCommand(machine);
}

}  // namespace intaglio::cli
