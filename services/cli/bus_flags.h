#pragma once

#include "services/bus/bus.h"

namespace CLI {
class App;
}

namespace intaglio::cli {

/// --domain, --interface, --tag: which shop is talked to.
void AddBusFlags(CLI::App& command, bus::BusOptions& options);

}  // namespace intaglio::cli
