#pragma once

// On a secured bus: lets a service notice that a peer whose loss matters has lost it
// (one_sided_loss.h). For this alone there is the topic Presence. The job service reads
// that of every cell and worker, a cell that of the job service, and the permissions let
// no other role read it. So an observer, an operator, a recorder or another cell that
// acknowledges nothing makes no service leave the bus.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/one_sided_loss.h"

namespace intaglio::host {

class Presence {
 public:
  /// Does nothing without an identity, and for roles that no other depends on.
  Presence(bus::Bus& bus, std::string instance);

  /// Every 200 ms. True when the service has to leave the bus for OneSidedLoss::kAway.
  bool Turn(OneSidedLoss::Time now);

 private:
  std::string instance_;
  std::unique_ptr<bus::Writer<intaglio_Presence>> writer_;
  std::unique_ptr<bus::Reader<intaglio_Presence>> peers_;
  OneSidedLoss loss_;
  std::uint64_t number_ = 0;
};

}  // namespace intaglio::host
