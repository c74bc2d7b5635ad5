#pragma once

// Publishes the living services that the job service has discovered, so that a client
// that has just joined knows whom to wait for, and what each of them reports
// (known_services.h). Used from one thread.

#include <chrono>
#include <map>
#include <string>

#include "services/job_service/published/known_services.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/process_instances.h"

namespace intaglio::job_service {

class ServiceList {
 public:
  /// `instance`: of the process, as in its health.
  ServiceList(bus::Bus& bus, std::string instance);
  /// Publishes a list that has changed. The first list comes when the bus has had its
  /// discovery_time() since the first call: before that a service that runs could be
  /// missing from it, and a client would take one machine of two for the only one. `now`:
  /// any steady clock.
  void Turn(std::chrono::nanoseconds now);
  /// As KnownServices.
  void SetLeftOut(const std::map<std::string, std::string>& workers) {
    known_.SetLeftOut(workers);
  }

 private:
  struct Entry {
    intaglio_ServiceRole role;
    std::string cell;
  };
  void TakeHealth(std::chrono::nanoseconds now);
  void Publish();

  std::string instance_;
  std::chrono::nanoseconds discovery_time_;
  std::chrono::nanoseconds first_turn_{-1};
  bus::Reader<intaglio_ServiceHealth> health_;
  bus::Writer<intaglio_ServiceList> lists_;
  KnownServices known_;
  host::ProcessInstances instances_;
  std::map<std::string, Entry> services_;  // by instance
  bool changed_ = true;
};

}  // namespace intaglio::job_service
