#pragma once

// Keeps the permission of every cell fresh on the safety profile: granted or not, every
// cell that ever had a job gets a sample every kPeriod. Silence means no permission as
// well.
//
// A cell stops firing after 90 ms of silence, and the thread that decides may wait longer
// than that for its disk. So a thread of this class repeats what was decided, as long as
// it was decided anew within kPatience: a job service that hangs is a silent one.
// Used from one thread.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "services/job_service/queue/job_queue.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/safety/stop_latch.h"

namespace intaglio::job_service {

class PermissionKeeper {
 public:
  static constexpr std::chrono::milliseconds kPeriod{20};
  static constexpr std::chrono::milliseconds kPatience{1000};

  explicit PermissionKeeper(bus::Bus& bus);

  /// Cells beyond these are closed when they have no job: a shop has some dozen machines,
  /// but a job may name any.
  static constexpr std::size_t kMaxCells = 64;

  /// A cell that will need it: its synchronizer has time to find the writer. May close
  /// another one, that is not `in_use` and whose emergency stop is not pressed: its
  /// synchronizer takes silence for no permission.
  void Open(const std::string& cell, const std::set<std::string>& in_use);
  /// Reads the emergency stops: every open cell, and whether its stop is pressed or was
  /// pressed since the last call.
  std::vector<std::pair<std::string, bool>> TakeStops();
  /// The presses that the machine holds. A press of a process that has ended already may
  /// reach the machine and not this one, and one that a reset named is none.
  void TakePresses(const std::string& cell, const std::vector<host::StopPress>& presses);
  /// What is to be repeated from now on; published at once when it is another. A cell
  /// that is not in `permissions` has no job and gets none.
  void Decide(const std::vector<PermissionView>& permissions);

 private:
  struct Cell {
    bus::Writer<intaglio_Permission> writer;
    bus::Reader<intaglio_EmergencyStop> stops;
    host::StopLatch stop;
    PermissionView decided;
    std::uint64_t number = 0;
    std::uint64_t opened = 0;  ///< grows with each Open
  };
  using Cells = std::map<std::string, Cell>;
  /// Out of the map and not closed yet; empty when all are in use.
  Cells::node_type TakeOneUnused(const std::set<std::string>& in_use);
  void Write(Cell& cell);
  void Repeat(const std::stop_token& stop);

  bus::Bus& bus_;
  std::mutex mutex_;  // of what follows
  Cells cells_;
  std::uint64_t opened_ = 0;
  std::chrono::steady_clock::time_point decided_at_;
  std::condition_variable_any ends_;
  std::jthread repeating_;
};

}  // namespace intaglio::job_service
