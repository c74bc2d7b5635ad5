#pragma once

// Keeps the permission of every cell fresh on the safety profile: granted or not, every
// cell that ever had a job is told every kPeriod. Silence means no permission as well.
// Used from one thread.

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/bus.h"
#include "services/host/stop_latch.h"
#include "services/job_service/job_queue.h"

namespace intaglio::job_service {

class PermissionKeeper {
 public:
  static constexpr std::chrono::milliseconds kPeriod{50};

  explicit PermissionKeeper(bus::Bus& bus) : bus_(bus) {}

  /// A cell that will need it: its synchronizer has time to find the writer.
  void Open(const std::string& cell);
  /// Publishes a cell at once when its permission has changed, and all when it is time. A
  /// cell that is not in `permissions` has no job and gets none.
  /// What was heard of the emergency stops: every open cell, and whether it is pressed.
  std::vector<std::pair<std::string, bool>> TakeStops();
  void Publish(const std::vector<PermissionView>& permissions, Nanoseconds now);

 private:
  struct Cell {
    bus::Writer<intaglio_Permission> writer;
    bus::Reader<intaglio_EmergencyStop> stops;
    host::StopLatch stop;
    PermissionView told;
    std::uint64_t number = 0;
  };
  void Write(Cell& cell);

  bus::Bus& bus_;
  std::map<std::string, Cell> cells_;
  Nanoseconds next_{0};
};

}  // namespace intaglio::job_service
