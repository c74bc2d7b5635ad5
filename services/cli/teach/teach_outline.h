#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `teach outline`: the guide laser shows where a job will be made, for as long as the
/// command runs.
void AddOutlineCommand(command_line::Command teach);

}  // namespace intaglio::cli
