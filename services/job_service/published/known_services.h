#pragma once

// Publishes what the job service knows of each living service and its machine
// (KnownService), for clients that do not discover cells. Used from one thread.

#include <chrono>
#include <map>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/machine_facts.h"
#include "services/platform/host/peers/process_instances.h"

namespace intaglio::job_service {

class KnownServices {
 public:
  /// A service in which nothing changes is published so often; only its age is new then.
  static constexpr std::chrono::seconds kPeriod{1};

  explicit KnownServices(bus::Bus& bus);
  /// A health that the process which it names has written.
  void Update(const intaglio_ServiceHealth& health, std::chrono::nanoseconds now);
  /// The service is gone; so is what was published of it, at once.
  void Remove(const std::string& instance);
  /// The workers that are given nothing more, and why, by instance.
  void SetLeftOut(const std::map<std::string, std::string>& workers);
  /// Takes reports of machines, and publishes what has changed or is due. `now`: any
  /// steady clock, as for Update.
  void Turn(std::chrono::nanoseconds now);

 private:
  struct Service {
    intaglio_ServiceRole role = intaglio_ROLE_JOB_SERVICE;
    intaglio_HealthState state = intaglio_HEALTH_STARTING;
    std::string host, cell, version, message, left_out;
    std::int32_t pid = 0;
    bool operator==(const Service&) const = default;
  };
  struct Known {
    Service service;
    std::chrono::nanoseconds reported_at{0}, next{0};
    bool changed = true;
  };
  void TakeReports();
  bool Publish(const std::string& instance, const Known& known,
               std::chrono::nanoseconds now);

  bus::Reader<intaglio_MachineReport> reports_;
  bus::Writer<intaglio_KnownService> writer_;
  std::map<std::string, Known> services_;            // by instance
  std::map<std::string, host::MachineFacts> facts_;  // by instance; may come before it
  host::ProcessInstances instances_;                 // of facts_
};

}  // namespace intaglio::job_service
