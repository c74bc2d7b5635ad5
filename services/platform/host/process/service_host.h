#pragma once

// What every service has in common: its options, log, signals, bus, name and health.
//
//   int main(int argc, char** argv) {
//     return host::RunService({.role = intaglio_ROLE_SORTER, .name = "sorter",
//                              .purpose = "puts points in the order of engraving"},
//                             argc, argv, [](host::ServiceHost& host) { return
//                             Sort(host); });
//   }

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::host {

struct ServiceDescription {
  intaglio_ServiceRole role;
  std::string
      name;  ///< e.g. "sorter": program intaglio-sorter, in logs and instance names
  std::string purpose;  ///< one line for --help
  /// Adds the service's own options; may be empty.
  std::function<void(command_line::Command)> add_options;
};

class ServiceHost {
 public:
  ServiceHost(const ServiceDescription& description, const bus::BusOptions& options);
  ~ServiceHost();

  bus::Bus& bus();
  /// Unique: InstanceName (identity_role.h).
  const std::string& instance() const;
  /// Set by SIGINT and SIGTERM.
  std::stop_token stop() const;
  bool stopping() const { return stop().stop_requested(); }

  /// Published at once, and again every 600 ms by KeepAlive.
  void SetHealth(intaglio_HealthState state, const std::string& job_uid = {},
                 const std::string& message = {});
  /// Until whoever follows this service has its newest health; half a second at most.
  void AwaitHealthReceived();
  /// To be called from the service's own loop at least every 200 ms: health reports that
  /// the loop runs, not that the process exists. Cheap when nothing is due.
  void KeepAlive();
  /// Raises an alarm on the bus and in the log.
  void RaiseAlarm(intaglio_AlarmSeverity severity, const std::string& code,
                  const std::string& message, const std::string& job_uid = {});

 private:
  void WarnOfExpiry();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Parses options (--domain, --interface, --tag, --cell, --log-file, --log-level and the
/// service's own), sets up log and signals, runs `body`, and turns what it throws into a
/// published fault and exit code 1. Exit code 2: wrong options.
int RunService(const ServiceDescription& description, int argc, char** argv,
               const std::function<int(ServiceHost&)>& body);

}  // namespace intaglio::host
