#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio proofs`: completes the folders of a cell's jobs in a shop whose services are
/// started by hand or by an init system, on the host of the machine.
void AddProofsCommand(command_line::Command app);

}  // namespace intaglio::cli
