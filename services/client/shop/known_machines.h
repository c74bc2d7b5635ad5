#pragma once

// The services and machines of a shop as its job service knows them (KnownService): for a
// client that does not discover cells. Used from one thread.

#include <map>
#include <string>
#include <vector>

#include "services/client/job_view.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/machine_facts.h"

namespace intaglio::client {

class KnownMachines {
 public:
  explicit KnownMachines(bus::Bus& bus);
  void Poll();
  /// Living services. reported_at is when the job service received their newest health,
  /// as far as the clocks of both computers agree: by at most that difference too new.
  /// Nothing is known once the job service is gone.
  std::vector<ServiceView> services() const;
  /// By name, of all services of the machine together.
  std::map<std::string, host::MachineFacts> machines() const;

 private:
  struct Known {
    ServiceView service;
    std::vector<host::MachineFacts> facts;  // one or none
  };
  bus::Reader<intaglio_KnownService> reader_;
  std::map<std::string, Known> known_;  // by instance
};

}  // namespace intaglio::client
