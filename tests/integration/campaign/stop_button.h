#pragma once

// An emergency stop that is ready on the bus, like that of an operator's panel: a press
// does not wait until services are discovered.

#include <chrono>
#include <cstdint>
#include <string>

#include "services/platform/bus/bus.h"

namespace intaglio::campaign {

class StopButton {
 public:
  StopButton(const bus::BusOptions& options, std::string cell);
  /// Waits until a service of the cell would receive it; false after the time.
  bool AwaitReceived(std::chrono::milliseconds bound) const;
  void Press() { Write(true); }
  /// Takes its own last press back.
  void Reset() { Write(false); }

 private:
  void Write(bool pressed);

  std::string cell_;
  bus::Bus bus_;
  bus::Writer<intaglio_EmergencyStop> stops_;
  std::string source_;
  std::uint64_t number_ = 0;
};

}  // namespace intaglio::campaign
