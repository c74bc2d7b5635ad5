#pragma once

// The live services of a bus: those that would obey or believe what is played there.
// Recorders, replayers and consoles only listen, and do not count.

#include <map>
#include <string>

#include "services/platform/bus/bus.h"

namespace intaglio::replayer {

class LiveServices {
 public:
  /// A service is known after the bus's discovery time.
  explicit LiveServices(bus::Bus& bus);
  /// Instances that serve now, as "synchronizer of els-03 (synchronizer-host-12-3)";
  /// never those of this process.
  const std::map<std::string, std::string>& Read();

 private:
  bus::Reader<intaglio_ServiceHealth> health_;
  std::map<std::string, std::string> serving_;  // descriptions by instance
};

}  // namespace intaglio::replayer
