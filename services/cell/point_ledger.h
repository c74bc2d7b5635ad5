#pragma once

// What is known of every point of a job, by its place in the order.
//
//   kPlanned --armed--> kArmed --fired, seen------> kMade
//    ^ ^                  |  \---fired, unseen----> kMissed
//    | |                  |   \--not known--------> kUncertain --+
//    | +--new run-- kSkipped <--not fired                        |
//    +-------------- a person's consent: fire it again ----------+
//
// kMade, kMissed and kLeftOut (a planned or skipped point that the operator chooses to
// leave out, or an armed mark that has no place on the web) are final: such a point is
// never armed again. So is kUncertain without consent.

#include <cstdint>
#include <optional>
#include <vector>

#include "engrave/formats/journal_file.h"

namespace intaglio::cell {

enum class PointState : std::uint8_t {
  kPlanned,
  kArmed,
  kMade,
  kMissed,
  kSkipped,
  kUncertain,
  kLeftOut,
};

class PointLedger {
 public:
  explicit PointLedger(std::size_t count)
      : states_(count, PointState::kPlanned), reopened_(count, false) {
    counts_[static_cast<std::size_t>(PointState::kPlanned)] = count;
  }

  std::size_t size() const { return states_.size(); }
  PointState state(std::uint32_t point) const { return states_[point]; }
  std::uint64_t count(PointState state) const {
    return counts_[static_cast<std::size_t>(state)];
  }

  /// Planned, skipped or left out (`state`), and uncertain before: it is not known
  /// whether they hold a crack, as long as they are not fired.
  std::uint64_t unknown_count(PointState state) const {
    return unknown_counts_[static_cast<std::size_t>(state)];
  }
  std::uint64_t unknown_count() const {
    return unknown_count(PointState::kPlanned) + unknown_count(PointState::kSkipped) +
           unknown_count(PointState::kLeftOut);
  }

  /// First point at or after `from` that may be armed: planned, or skipped earlier.
  std::optional<std::uint32_t> NextOpen(std::uint32_t from) const;
  /// No point at or after this place was ever made, missed or uncertain.
  std::uint32_t ended_below() const { return ended_below_; }
  bool all_ended() const {
    return count(PointState::kPlanned) + count(PointState::kSkipped) +
               count(PointState::kArmed) ==
           0;
  }

  /// Throws PreconditionError unless the point is planned or skipped.
  void Arm(std::uint32_t point);
  /// For good, by the operator's choice. Throws unless the point is planned or skipped.
  void LeaveOut(std::uint32_t point);
  /// By a person's consent. Throws PreconditionError unless the point is uncertain.
  void Reopen(std::uint32_t point);
  /// Throws PreconditionError unless the point is armed; `outcome` is not kNone.
  void Resolve(std::uint32_t point, formats::PointOutcome outcome);

 private:
  void Move(std::uint32_t point, PointState to);
  std::vector<PointState> states_;
  std::vector<bool> reopened_;  // once
  std::uint64_t counts_[7] = {};
  std::uint64_t unknown_counts_[7] = {};
  std::uint32_t ended_below_ = 0;
};

}  // namespace intaglio::cell
