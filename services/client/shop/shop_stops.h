#pragma once

// The emergency stop of the bus, from a client's side: pressing it, and what the machines
// report of it.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "services/client/job_view.h"
#include "services/client/listed_services.h"
#include "services/platform/bus/bus.h"

namespace intaglio::client {

/// The name of a machine that stands for every machine: their readers match it.
inline constexpr char kEveryMachine[] = "*";

struct HeldPress {
  std::string source;
  std::uint64_t number = 0;
};
using HeldPresses = std::vector<HeldPress>;

/// The press is among them, or a later one of its source.
bool Names(const HeldPresses& presses, const std::string& source, std::uint64_t number);

/// This process as a source of EmergencyStop. What it sent last reaches every machine
/// that starts while it lives. Its end releases nothing. From any thread, one at a time.
class StopSource {
 public:
  /// `program`: the beginning of its name, e.g. "intaglio-stop"; no other process has the
  /// rest, on any host, at any time. `cell`: a machine, or kEveryMachine.
  StopSource(bus::Bus& bus, const std::string& program, std::string cell);

  const std::string& name() const { return name_; }
  /// The number of the press.
  Result<std::uint64_t> Press(const std::string& reason);
  Result<std::uint64_t> Release(const HeldPresses& presses, const std::string& reason);

 private:
  Result<std::uint64_t> Send(bool pressed, const std::string& reason,
                             const HeldPresses& presses);

  const std::string name_, operator_name_ = OperatorName();
  const std::string cell_;
  bus::Writer<intaglio_EmergencyStop> writer_;
  std::uint64_t number_ = 0;
};

/// A machine's emergency stops, as its synchronizer reports them.
struct MachineStops {
  bool reported = false;
  bool pressed = false;
  HeldPresses held;
  bool laser_line_up = false;  ///< the next four are known only if it is
  bool key_on = false, door_closed = false, own_stop_released = false;
  bool shutters_closed = false;
};

/// Collects what one machine, or every machine of the shop, reports. From one thread.
class MachineReports {
 public:
  /// `cell` empty: every machine.
  MachineReports(bus::Bus& bus, const std::string& cell);

  const std::map<std::string, MachineStops>& Poll();
  /// A job service lists the machines of the shop, and each of them has come. False
  /// without a job service, and where one machine is named.
  bool KnowsAllMachines() const;
  const MachineStops& Of(const std::string& cell) { return Poll().at(cell); }

 private:
  void Add(const intaglio_ServiceHealth& sample);

  bus::Reader<intaglio_Interlock> interlocks_;
  // Null where one machine is named.
  std::unique_ptr<bus::Reader<intaglio_ServiceHealth>> health_;
  std::unique_ptr<ListedServices> listed_;
  std::map<std::string, MachineStops> machines_;
};

}  // namespace intaglio::client
