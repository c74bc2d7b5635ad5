#pragma once

// Arms one job once, for a command that a person typed beside the machine. A later pause,
// stop or lost grant is left to a person.
//
//   kWaits --the machine has the job--> kAsked --taken--> kArmed
//     ^                                    |--not yet------+
//     +------------------------------------+
//                                          +--refused----> kLeft
//   kWaits --a program's arm needs another block (awaits_block)--> kWaits, until the
//            machine was opened and is closed again
//   kWaits --paused, stopped or disarmed meanwhile, but not by the door that is opened to
//            change the block-----------------------------> kLeft
//   kWaits --another job got the machine: its block may be in----> kWaits, as a program
//   kWaits --something was reported as mounted after the person's word, which was given
//            for what was mounted before------------------> kLeft
//   kWaits --ended, or armed by another person-----------> kArmed

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "services/client/job_client.h"

namespace intaglio::client {

/// What the person who typed the command has stated.
struct ArmTerms {
  bool accept_breakage = false;  ///< the glass may break
  intaglio_ArmBasis basis = intaglio_ARM_BY_PROGRAM;
};

/// A person types this command for one job: its block is in, unless another job has
/// the machine or waits for it; then the arm is a program's. `same_block`: the person has
/// stated that every job goes into the block that is in.
intaglio_ArmBasis BasisFor(const JobClient& client, const JobView& submitted,
                           bool same_block);

class ArmOnce {
 public:
  enum class State { kWaits, kAsked, kArmed, kLeft };

  /// `submitted`: the job as the person who arms it knows it.
  ArmOnce(JobClient& client, const JobView& submitted, const ArmTerms& terms)
      : client_(&client), disarm_count_(submitted.disarm_count), terms_(terms) {
    NoteMounted(submitted.cell);
  }

  /// The next step, by the newest status of the job. After every Poll of the client.
  State Follow(const JobView& job);
  State state() const { return state_; }
  /// The count of the status on which it arms: a greater one has taken its arm back.
  std::uint64_t disarm_count() const { return disarm_count_; }
  /// It waits for another block: what a person has to do; empty: it does not.
  std::string WhatBlockItAwaits(const JobView& job) const;
  /// Why it was left.
  const std::string& reason() const { return reason_; }

 private:
  bool IsChangeOfBlock(const JobView& job) const;
  bool AnotherHasItsMachine(const JobView& job) const;
  /// True when another report is known than the first one of this machine.
  bool NoteMounted(const std::string& cell);
  void Ask(const JobView& job);
  void TakeAnswer();
  void Leave(const std::string& reason);

  JobClient* client_;
  std::uint64_t disarm_count_;
  ArmTerms terms_;
  std::uint64_t asked_ = 0;  // number of the command
  State state_ = State::kWaits;
  bool awaited_block_ = false;
  std::string mounted_utc_;  // of the first report that is known; empty: none
  std::string reason_;
};

/// Time in which a machine that is free takes a job.
inline constexpr std::chrono::seconds kMachineTakesJobWithin{15};

/// Follows the job until it is armed: kRefused with the reason, also when its machine was
/// not opened since the last piece; kTimedOut, and not armed, when its machine has not
/// taken it by then.
Status ArmWhenTaken(JobClient& client, const JobView& submitted, const ArmTerms& terms,
                    std::chrono::milliseconds timeout = kMachineTakesJobWithin);

}  // namespace intaglio::client
