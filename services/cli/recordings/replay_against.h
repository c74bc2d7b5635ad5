#pragma once

// `intaglio replay --against SERVICE`: what today's service makes of a recorded session,
// compared with what was made then.

#include <string>
#include <vector>

namespace intaglio::cli {

struct AgainstOptions {
  std::string file;
  std::string service;               ///< "sorter", "discretizer" or "synchronizer"
  std::vector<std::string> changes;  ///< PATH=VALUE, options of the job
  bool json = false;
};

/// Starts the service alone, on a bus that no other process sees. Its exit code:
/// identical 0, different 3, the service died or hung 4, interrupted 5, no such
/// recording 2.
int ReplayAgainst(const AgainstOptions& options);

}  // namespace intaglio::cli
