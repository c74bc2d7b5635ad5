#pragma once

// The health of a process on the bus: what every service and each web console publish of
// themselves. From one thread.

#include <chrono>
#include <string>

#include "idl/service.h"
#include "services/platform/bus/bus.h"

namespace intaglio::host {

class HealthWriter {
 public:
  using Clock = std::chrono::steady_clock;
  /// `name`: e.g. "sorter". Throws BusError, also where the identity may not write it.
  HealthWriter(bus::Bus& bus, intaglio_ServiceRole role, const std::string& name);

  /// Unique: InstanceName (identity_role.h).
  const std::string& instance() const { return instance_; }
  intaglio_HealthState state() const { return state_; }
  /// Published at once. False: nothing has changed.
  bool Set(intaglio_HealthState state, const std::string& job_uid,
           const std::string& message);
  void Publish();
  /// Publishes again when it is due, every 600 ms.
  void Turn(Clock::time_point now);
  /// Until whoever follows it has the newest; kTimedOut.
  Status WaitForAcknowledgements(std::chrono::milliseconds patience) {
    return writer_.WaitForAcknowledgements(patience);
  }

 private:
  bus::Bus& bus_;
  intaglio_ServiceRole role_;
  bus::Writer<intaglio_ServiceHealth> writer_;
  std::string host_, instance_;
  intaglio_HealthState state_ = intaglio_HEALTH_STARTING;
  std::string job_uid_, message_;
  Clock::time_point next_publication_{};
};

}  // namespace intaglio::host
