#pragma once

// A shop as it is on the bus at one moment.

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "services/client/job_client.h"
#include "services/client/shop/known_machines.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/machine_facts.h"

namespace intaglio::client {

/// One machine; its position is known only where the client discovers it.
struct CellSnapshot : host::MachineFacts {
  double x_mm = 0, y_mm = 0, z_mm = 0;
  bool at_rest = false;
};

struct ShopSnapshot {
  std::chrono::steady_clock::time_point taken_at;
  std::vector<ServiceView> services;
  std::vector<JobView> jobs;
  std::vector<DiskView> disks;
  std::map<std::string, CellSnapshot> cells;  ///< by name
  std::map<std::string, MountView> mounts;    ///< by machine
};

/// The job service among these; nullptr: none.
const ServiceView* FindJobService(const std::vector<ServiceView>& services);
/// A synchronizer or bridge, of the machine that its `cell` names.
bool IsOfMachine(const ServiceView& service);
/// Another than the job service's (nullptr: none is there): neither understands all that
/// the other says.
bool HasAnotherVersion(const ServiceView& service, const ServiceView* job_service);
/// A service of the machine has another version than the job service, so that what is
/// known of the machine may be wrong or missing.
bool HasAnotherVersion(const std::string& cell, const std::vector<ServiceView>& services);

/// Follows a shop: its machines themselves, or on a bus that does not meet them
/// (BusOptions::meets_cells) by what the job service knows of them. Used from one thread.
class ShopWatcher {
 public:
  explicit ShopWatcher(bus::Bus& bus);
  /// Takes what comes within `time`.
  void Poll(std::chrono::milliseconds time);
  /// All that a working shop has is here: the services that its job service lists, its
  /// jobs and its disks, and of every machine with a synchronizer its interlocks, of
  /// every one with a bridge its motion; but of no service of another version than the
  /// job service's, whose messages nobody may understand here.
  bool IsComplete() const;
  /// A job service is there.
  bool IsServed() const;
  ShopSnapshot Take() const;
  /// For commands.
  JobClient& client() { return client_; }

 private:
  struct Cells {
    explicit Cells(bus::Bus& bus);
    void Take();
    bus::Reader<intaglio_Interlock> interlocks;
    bus::Reader<intaglio_LampSync> lamps;
    bus::Reader<intaglio_MotionState> motion;
    std::map<std::string, CellSnapshot> cells;
  };
  std::vector<ServiceView> services() const;
  std::map<std::string, CellSnapshot> cells() const;

  JobClient client_;
  // One of the two.
  std::unique_ptr<Cells> met_;
  std::unique_ptr<KnownMachines> known_;
};

}  // namespace intaglio::client
