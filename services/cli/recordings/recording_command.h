#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio recording info|list|export|repair|merge|cut`.
void AddRecordingCommand(command_line::Command app);

}  // namespace intaglio::cli
