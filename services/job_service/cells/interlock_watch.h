#pragma once

// Key and door of every machine that has a job, and the emergency stops of the bus that
// hold it, from the Interlock of its synchronizer or marker. Used from one thread.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/job_service/cells/piece_book.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/safety/stop_latch.h"

namespace intaglio::job_service {

struct InterlockReport {
  std::string cell;
  DoorState door = DoorState::kUnknown;
  std::vector<host::StopPress> stops_held;
};

class InterlockWatch {
 public:
  explicit InterlockWatch(bus::Bus& bus) : bus_(bus) {}

  /// Retained samples come at once.
  void OpenCell(const std::string& cell);
  /// What was received since the last call, in its order: a door that was opened and
  /// closed in between is in it with both.
  std::vector<InterlockReport> Take();

 private:
  bus::Bus& bus_;
  std::map<std::string, bus::Reader<intaglio_Interlock>> readers_;  // by cell
};

}  // namespace intaglio::job_service
