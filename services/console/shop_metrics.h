#pragma once

// What a monitoring program collects of a shop, in the text format of Prometheus
// (https://prometheus.io/docs/instrumenting/exposition_formats/, version 0.0.4). Counters
// begin at 0 with the console.

#include <chrono>
#include <map>
#include <string>
#include <utility>

#include "proto/shop.pb.h"

namespace intaglio::console {

/// What a machine does with its time, e.g. "engraving", "idle", "paused_interlock".
///
/// clang-format off
///   unknown            laser or stage do not answer
///   stopped            an emergency stop of the bus holds it
///   idle               it has no job
///   no_progress        its job is engraved and has an alarm
///   paused_REASON      PauseReason of idl/job.idl, as in the events
///   any other          the state of its job, as in the events
/// clang-format on
std::string OccupationOf(const MachineStatus& machine, const ShopStatus& shop);

/// Used from one thread.
class ShopMetrics {
 public:
  using Clock = std::chrono::steady_clock;

  /// The time since the call before counts for what the machines did then; more than 2 s,
  /// of a computer that slept, count for nothing.
  void Follow(const ShopStatus& shop, Clock::time_point now);
  /// A job that ended while the console ran; `verdict` as in the history.
  void CountPiece(const std::string& cell, const std::string& verdict);
  std::string Text() const;

 private:
  using Labels =
      std::pair<std::string, std::string>;  // machine, and occupation or verdict
  ShopStatus shop_;
  Clock::time_point followed_{};
  std::map<Labels, double> seconds_;
  std::map<Labels, std::uint64_t> pieces_;
};

}  // namespace intaglio::console
