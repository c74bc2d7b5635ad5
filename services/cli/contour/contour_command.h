#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio contour`: contours and holes of circuit boards and plates, as figures, a
/// picture, a project and programs.
void AddContourCommand(command_line::Command app);

}  // namespace intaglio::cli
