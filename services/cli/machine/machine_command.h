#pragma once

// `intaglio machine`: the profile of a machine, made, checked, corrected and compared.

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

void AddMachineCommand(command_line::Command app);

/// Each adds one command below `machine`.
void AddMachineCheckCommand(command_line::Command machine);
void AddMachineCompareCommand(command_line::Command machine);
void AddMachineNewCommand(command_line::Command machine);
void AddMachineMeasureCommand(command_line::Command machine);

}  // namespace intaglio::cli
