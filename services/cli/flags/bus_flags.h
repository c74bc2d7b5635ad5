#pragma once

#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --domain, --interface, --tag, --security: which shop is talked to, and as whom.
void AddBusFlags(command_line::Command command, bus::BusOptions& options);

}  // namespace intaglio::cli
