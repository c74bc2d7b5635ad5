#pragma once

// A machine has one synchronizer and one motion bridge, a shop one job service. Defines
// what a second process of the same kind does.
//
//   OnlyInstance only(host, role);
//   if (only.AwaitTurn()) return only.EndAsSecond("synchronizer");   // nothing touched

#include <chrono>
#include <string>

#include "services/platform/host/peers/rival_watch.h"
#include "services/platform/host/process/service_host.h"

namespace intaglio::host {

/// Exit codes of a service that leaves its work to another process.
inline constexpr int kExitSecond = 3;
inline constexpr int kExitTakenOver = 4;

/// Follows ServiceHealth for others of the same role and cell (of the same role, where
/// there is one for all cells); only what such a process itself has written counts, with
/// the identity of this one. From one thread.
class OnlyInstance {
 public:
  using Starting = RivalWatch::Starting;

  OnlyInstance(ServiceHost& host, intaglio_ServiceRole role,
               Starting starting = Starting::kIsRival);

  /// Waits until this process may go on, 0.25 s when it is alone on its computer, longer
  /// on a network or when one before it has just died. True: it has to end instead.
  bool AwaitTurn();
  /// For a process that already works: true when another one, not seen at the start,
  /// takes precedence and this one has to end.
  bool MustEnd();
  /// Reports the other process on the bus and in the log. Returns kExitSecond.
  int EndAsSecond(const std::string& name);

 private:
  void Take();

  ServiceHost& host_;
  intaglio_ServiceRole role_;
  bus::Reader<intaglio_ServiceHealth> health_;
  RivalWatch watch_;
};

/// The last report of a service whose machine a newer host has taken: a fault on the bus
/// and in the log. `name` is the kind of service, "synchronizer". Returns kExitTakenOver.
int EndTakenOver(ServiceHost& host, const std::string& name);

}  // namespace intaglio::host
