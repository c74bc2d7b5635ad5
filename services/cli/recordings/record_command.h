#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio record`: becomes intaglio-recorder, which Ctrl-C ends.
void AddRecordCommand(command_line::Command app);

}  // namespace intaglio::cli
