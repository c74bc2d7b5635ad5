#pragma once

#include <functional>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// As `intaglio submit FILE`, not armed; the exit code.
using SubmitFile =
    std::function<int(const bus::BusOptions& bus, const std::string& file)>;

/// `teach pulse` and `teach focus`: jobs of points at the present place, which a person
/// arms, and the zero by the first visible crack. `submit`: for those jobs.
void AddTestPulseCommands(command_line::Command teach, const SubmitFile& submit);

}  // namespace intaglio::cli
