#pragma once

// intaglio preview: picture, time, size and warnings of a job, before anything runs.

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

void AddPreviewCommand(command_line::Command app);

}  // namespace intaglio::cli
