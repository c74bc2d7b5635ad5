#pragma once

#include "services/cli/teach/teach_pulse.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio teach`: moves a machine by hand and teaches its zeros and positions.
/// `submit`: for the jobs of its test pulses.
void AddTeachCommand(command_line::Command app, const SubmitFile& submit);

}  // namespace intaglio::cli
