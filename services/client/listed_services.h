#pragma once

// The services of a shop as its job service lists them (ServiceList): whom a client that
// has just joined the bus waits for, in place of the longest time that discovery takes.

#include <map>
#include <set>
#include <string>
#include <vector>

#include "services/platform/bus/bus.h"

namespace intaglio::client {

/// The roles of the services that only a machine has.
inline const std::set<intaglio_ServiceRole> kMachineRoles = {intaglio_ROLE_SYNCHRONIZER,
                                                             intaglio_ROLE_MOTION_BRIDGE};

struct ListedService {
  std::string instance;
  intaglio_ServiceRole role;
  std::string cell;  ///< empty: all cells
};

/// Used from one thread.
class ListedServices {
 public:
  explicit ListedServices(bus::Bus& bus);
  void Poll();
  /// By the instance of the job service. Empty: no list has come, or there is no job
  /// service; then nothing is known of who is missing.
  const std::map<std::string, std::vector<ListedService>>& lists() const {
    return lists_;
  }
  /// The cells of the listed services with one of the roles.
  std::set<std::string> Cells(const std::set<intaglio_ServiceRole>& roles) const;
  /// Some cell has a listed service with one of the roles, and each such cell is among
  /// `found`: a client that has found one machine knows then that it is the only one.
  bool AreAllIn(const std::set<std::string>& found,
                const std::set<intaglio_ServiceRole>& roles) const;

 private:
  bus::Reader<intaglio_ServiceList> reader_;
  std::map<std::string, std::vector<ListedService>> lists_;
};

}  // namespace intaglio::client
