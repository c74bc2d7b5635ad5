#pragma once

// Passes on the samples of people who move or teach a machine from somewhere else, each
// once: it repeats nothing by itself, so that the rule of the motion bridge holds from
// the finger to the axis. A sample has the number of the machine's state that the person
// saw last, and one that is older than 200 ms moves nothing, whatever delayed it
// (services/cell/manual). When the samples stop, for whatever reason, the stage rests
// within 200 ms and the time of braking.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "idl/teach.h"
#include "services/client/teach_client.h"
#include "services/platform/bus/bus.h"

namespace intaglio::client {

class JogRelay {
 public:
  explicit JogRelay(bus::Bus& bus);

  /// "PROGRAM-PID-RANDOM-PERSON".
  std::string SenderOf(std::uint64_t person) const;
  /// From any thread. kNotFound: no such machine is there. kInvalidValue: a number that
  /// is none, or an order of outlines. kRefused: the identity may not command.
  Status Pass(const SentOrder& sent);
  /// The machines whose state has come since the last call; from one thread.
  std::vector<MachineView> TakeNew();

 private:
  bus::Bus& bus_;
  const std::string process_;
  bus::Reader<intaglio_ManualState> states_;
  std::mutex mutex_;  // of what follows
  /// By machine; null until somebody moves it.
  std::map<std::string, std::unique_ptr<bus::Writer<intaglio_ManualCommand>>> commands_;
};

}  // namespace intaglio::client
