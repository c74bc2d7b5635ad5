#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio course plan`: the speed along the contours of a drawing.
void AddCourseCommand(command_line::Command app);

}  // namespace intaglio::cli
