#pragma once

#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --domain, --interface, --tag, --security: the shop to connect to, and the identity.
void AddBusFlags(command_line::Command command, bus::BusOptions& options);

}  // namespace intaglio::cli
