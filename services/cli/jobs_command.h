#pragma once

#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// The commands that talk to a running shop: submit, list, show, watch, arm, pause,
/// resume, cancel.
void AddJobsCommands(command_line::Command app);

/// As `intaglio submit FILE`, not armed; the exit code.
int SubmitJobFile(const bus::BusOptions& bus, const std::string& file);

}  // namespace intaglio::cli
