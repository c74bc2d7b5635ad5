#pragma once

// A bus that no other process sees, for tests of services.

#include <fmt/format.h>
#include <unistd.h>

#include <string>

#include "services/platform/bus/bus.h"
#include "tests/own_network.h"
#include "tests/patience.h"

namespace intaglio::test {

/// The same for all calls in one process; children get it by their command line.
inline std::string PrivateTag() { return fmt::format("test-{}", getpid()); }

inline bus::BusOptions PrivateBusOptions(const std::string& cell = {},
                                         const std::string& role = {}) {
  bus::BusOptions options;
  options.tag = PrivateTag();
  options.cell = cell;
  if (!role.empty()) options.roles = {role};
  return options;
}

}  // namespace intaglio::test
