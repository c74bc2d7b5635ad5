#pragma once

namespace CLI {
class App;
}

namespace intaglio::cli {

/// --size-limits: the factor of proto/read_limits.h.
void AddSizeLimitsFlag(CLI::App& command, double& factor);

/// The same for the programs that this one starts.
void HandOnSizeLimits(double factor);

}  // namespace intaglio::cli
