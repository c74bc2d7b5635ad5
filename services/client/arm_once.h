#pragma once

// Arms one job once, for a command that a person typed beside the machine. A later pause,
// stop or lost grant is left to a person.
//
//   kWaits --the machine has the job--> kAsked --taken--> kArmed
//     ^                                    |--not yet------+
//     +------------------------------------+
//                                          +--refused----> kLeft
//   kWaits --paused, stopped or disarmed meanwhile-------> kLeft
//   kWaits --ended, or armed by another person-----------> kArmed

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "services/client/job_client.h"

namespace intaglio::client {

class ArmOnce {
 public:
  enum class State { kWaits, kAsked, kArmed, kLeft };

  /// `submitted`: the job as the person who arms it knows it. `accept_breakage`: this
  /// person accepts that the glass may break.
  ArmOnce(JobClient& client, const JobView& submitted, bool accept_breakage)
      : client_(&client),
        disarm_count_(submitted.disarm_count),
        accept_breakage_(accept_breakage) {}

  /// The next step, by the newest status of the job. After every Poll of the client.
  State Follow(const JobView& job);
  State state() const { return state_; }
  /// Of the status on which it arms: a greater one has taken its arm back.
  std::uint64_t disarm_count() const { return disarm_count_; }
  /// Why it was left.
  const std::string& reason() const { return reason_; }

 private:
  void Ask(const JobView& job);
  void TakeAnswer();
  void Leave(const std::string& reason);

  JobClient* client_;
  std::uint64_t disarm_count_;
  bool accept_breakage_;
  std::uint64_t asked_ = 0;  // number of the command
  State state_ = State::kWaits;
  std::string reason_;
};

/// Time in which a machine that is free takes a job.
inline constexpr std::chrono::seconds kMachineTakesJobWithin{15};

/// Follows the job until it is armed: kRefused with the reason; kTimedOut, and not armed,
/// when its machine has not taken it by then.
Status ArmWhenTaken(JobClient& client, const JobView& submitted, bool accept_breakage,
                    std::chrono::milliseconds timeout = kMachineTakesJobWithin);

}  // namespace intaglio::client
