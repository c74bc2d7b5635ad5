#pragma once

// `intaglio drive`: what the drives of a machine can do, from a drive profile.

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

void AddDriveCommand(command_line::Command app);

/// Each adds its command below `drive`.
void AddDriveSizeCommand(command_line::Command drive);
void AddDriveTuneCommands(command_line::Command drive);  ///< tune and compare
void AddDriveSimulateCommand(command_line::Command drive);
void AddDriveIdentifyCommand(command_line::Command drive);
void AddDriveCornerCommand(command_line::Command drive);
void AddDriveCircleCommand(command_line::Command drive);

}  // namespace intaglio::cli
