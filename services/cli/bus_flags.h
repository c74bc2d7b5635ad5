#pragma once

#include "services/bus/bus.h"

namespace CLI {
class App;
}

namespace intaglio::cli {

/// --domain, --interface, --tag, --security: which shop is talked to, and as whom.
void AddBusFlags(CLI::App& command, bus::BusOptions& options);

}  // namespace intaglio::cli
