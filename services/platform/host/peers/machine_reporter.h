#pragma once

// Publishes what a service of a cell knows of its machine, as MachineReport: what the job
// service answers clients from that do not discover cells. While nothing changes it is
// sent once a second, for a reader that had lost this process and has it back, so that a
// shop at rest pays little for it; that the service lives, its health says. From one
// thread.

#include <chrono>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/machine_facts.h"

namespace intaglio::host {

class MachineReporter {
 public:
  /// Between two reports, of a lamp that warms up or a block that is carried.
  static constexpr std::chrono::milliseconds kShortestPeriod{50};
  /// Between two reports in which nothing has changed.
  static constexpr std::chrono::seconds kUnchangedPeriod{1};

  /// `instance`: as in the health of the service.
  MachineReporter(bus::Bus& bus, std::string instance)
      : instance_(std::move(instance)), writer_(bus, bus::kMachineReport) {}

  /// An Interlock, LampSync or MotionState of the machine, as it is written.
  template <typename Sample>
  void Update(const Sample& sample) {
    host::Update(facts_, sample);
  }
  /// Publishes what has changed or is due. `now`: any steady clock.
  void Turn(std::chrono::nanoseconds now);

 private:
  std::string instance_;
  bus::Writer<intaglio_MachineReport> writer_;
  MachineFacts facts_, published_;
  std::chrono::nanoseconds next_{0}, next_unchanged_{0};
};

}  // namespace intaglio::host
