#pragma once

#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --domain, --interface, --tag, --security: the shop to connect to, and the identity;
/// without them, what INTAGLIO_DOMAIN, _INTERFACE, _TAG and _SECURITY have.
void AddBusFlags(command_line::Command command, bus::BusOptions& options);

/// The same of a session with services of its own, which has a private tag: a shop that
/// the environment names is not joined.
void AddPrivateBusFlags(command_line::Command command, bus::BusOptions& options);

/// For a command that the job service alone answers: it meets no machine, so that its
/// time does not grow with their number.
bus::BusOptions WithoutCells(bus::BusOptions options);

}  // namespace intaglio::cli
