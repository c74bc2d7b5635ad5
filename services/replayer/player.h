#pragma once

// Plays a recording: every chosen sample on a topic of its type, with the QoS, partition,
// bytes and source time stamp that it had, in the order and at the pace of its reception.
//
// From one thread. It holds the writers as long as it lives: what they retain is there
// until then.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/platform/bus/cdr_writer.h"
#include "services/replayer/credit_gate.h"
#include "services/replayer/retained.h"
#include "services/replayer/selection.h"

namespace intaglio::replayer {

struct PlayOptions {
  std::uint64_t from_ns = 0;  ///< log time, included; before it only what is retained
  /// Not included; absent: to the end.
  std::optional<std::uint64_t> to_ns = std::nullopt;
  double rate = 1;         ///< times real time, above 0
  bool by_credit = false;  ///< as fast as consumers give credit; the rate does not count
};

struct PlayHooks {
  /// Asked before every sample and every 20 ms of waiting; false ends the play.
  std::function<bool()> keep_on;
  /// Before a sample, once its time has come; may wait. Null: all at once. False ends.
  std::function<bool(const PlayedChannel& channel, std::uint64_t log_time_ns)> admit;
};

struct PlayReport {
  std::uint64_t played_count = 0;
  std::uint64_t restored_count = 0;  ///< retained samples from before the start or file
  bool whole = false;                ///< to its end
  std::vector<std::string> complaints;
};

class Player {
 public:
  /// kMissing: the recording has no type of a topic. Others as CdrPublisher. Readers find
  /// the writers within the bus's discovery time.
  static Result<std::unique_ptr<Player>> Make(bus::Bus& bus, bus::CdrPublisher& publisher,
                                              const recording::McapReader& reader,
                                              Selection selection);
  /// May be called again: everything from the start once more.
  PlayReport Play(const PlayOptions& options, const PlayHooks& hooks);
  /// Waits until all readers have everything, this long at most.
  void Settle(std::chrono::milliseconds timeout);

 private:
  Player(bus::Bus& bus, const recording::McapReader& reader, Selection selection);
  Status MakeWriters(bus::CdrPublisher& publisher);
  bool WaitUntil(std::chrono::steady_clock::time_point due, const PlayHooks& hooks) const;
  bool WaitForCredit(const PlayedChannel& channel, const bus::CdrWriter& writer,
                     recording::ByteView payload, const PlayHooks& hooks);
  bool Write(std::uint16_t channel_id, std::uint64_t publish_time_ns,
             recording::ByteView payload, const PlayHooks& hooks, PlayReport& report);
  void Restore(const PlayOptions& options, const PlayHooks& hooks, PlayReport& report);

  const recording::McapReader& reader_;
  Selection selection_;
  CreditGate gate_;
  std::vector<std::unique_ptr<bus::CdrWriter>> writers_;
  std::map<std::uint16_t, bus::CdrWriter*> writer_of_;  // by channel
};

}  // namespace intaglio::replayer
