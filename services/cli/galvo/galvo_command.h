#pragma once

// `intaglio galvo`: scan heads, their correction and what they can mark.

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

void AddGalvoCommand(command_line::Command app);

/// Each adds its command below `galvo`.
void AddGalvoGridCommand(command_line::Command galvo);
void AddGalvoCalibrateCommand(command_line::Command galvo);
void AddGalvoPlanCommand(command_line::Command galvo);
void AddGalvoTicksCommand(command_line::Command galvo);

}  // namespace intaglio::cli
