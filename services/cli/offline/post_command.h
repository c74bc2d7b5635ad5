#pragma once

// `intaglio post`: the program of a job for a controller of another maker.

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

void AddPostCommand(command_line::Command app);

}  // namespace intaglio::cli
