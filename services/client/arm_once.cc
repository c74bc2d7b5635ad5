#include "services/client/arm_once.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::client {

ArmOnce::State ArmOnce::Follow(const JobView& job) {
  if (state_ == State::kAsked) TakeAnswer();
  if (state_ != State::kWaits) return state_;
  if (terms_.basis == intaglio_ARM_BY_PERSON && AnotherHasItsMachine(job))
    terms_.basis = intaglio_ARM_BY_PROGRAM;
  awaited_block_ = awaited_block_ || !WhatBlockItAwaits(job).empty();
  if (job.ended() || job.armed) {
    state_ = State::kArmed;
  } else if (job.disarm_count != disarm_count_) {
    Leave(job.disarm_reason);
  } else if (job.state == intaglio_JOB_PAUSED && !IsChangeOfBlock(job)) {
    Leave(job.message);
  } else if (NoteMounted(job.cell) && terms_.basis != intaglio_ARM_BY_PROGRAM) {
    const MountView& mount = client_->mounts().at(job.cell);
    Leave(fmt::format("{} has reported what is mounted, {}", mount.operator_name,
                      TextOf(mount.parts)));
  } else if (job.state != intaglio_JOB_QUEUED && WhatBlockItAwaits(job).empty()) {
    Ask(job);
  }
  return state_;
}

bool ArmOnce::AnotherHasItsMachine(const JobView& job) const {
  return std::ranges::any_of(client_->jobs(), [&job](const auto& other) {
    const JobView& view = other.second;
    return view.uid != job.uid && view.cell == job.cell && !view.ended() &&
           view.state != intaglio_JOB_QUEUED;
  });
}

// What is known first may arrive later than the job.
bool ArmOnce::NoteMounted(const std::string& cell) {
  const auto mount = client_->mounts().find(cell);
  if (mount == client_->mounts().end()) return false;
  if (mounted_utc_.empty()) mounted_utc_ = mount->second.mounted_utc;
  return mounted_utc_ != mount->second.mounted_utc;
}

// A door that is opened while nothing was armed yet is what it waits for.
bool ArmOnce::IsChangeOfBlock(const JobView& job) const {
  return awaited_block_ && job.pause_reason == intaglio_PAUSE_INTERLOCK;
}

void ArmOnce::Ask(const JobView& job) {
  const auto sent = client_->Send(job, {.kind = intaglio_COMMAND_ARM,
                                        .accept_breakage = terms_.accept_breakage,
                                        .basis = terms_.basis});
  if (!sent) return Leave(sent.error().message);
  asked_ = *sent;
  state_ = State::kAsked;
}

void ArmOnce::TakeAnswer() {
  const auto answer = client_->AnswerTo(asked_);
  if (!answer) return;
  if (answer->taken()) {
    state_ = State::kArmed;
  } else if (answer->code == intaglio_ANSWER_NOT_YET ||
             answer->code == intaglio_ANSWER_SAME_BLOCK) {
    // It lost its machine, or had no other block, before the command came.
    state_ = State::kWaits;
  } else {
    Leave(answer->message);
  }
}

void ArmOnce::Leave(const std::string& reason) {
  state_ = State::kLeft;
  reason_ = reason;
}

std::string ArmOnce::WhatBlockItAwaits(const JobView& job) const {
  if (!job.awaits_block || terms_.basis != intaglio_ARM_BY_PROGRAM ||
      state_ != State::kWaits) {
    return {};
  }
  return fmt::format(
      "neither key nor door of {} was opened and closed since the piece before it: open "
      "the door, change the {} and close it, and the job is armed",
      job.cell, job.workpiece());
}

intaglio_ArmBasis BasisFor(const JobClient& client, const JobView& submitted,
                           bool same_block) {
  if (same_block) return intaglio_ARM_SAME_BLOCK;
  for (const auto& [uid, other] : client.jobs()) {
    if (uid != submitted.uid && other.cell == submitted.cell && !other.ended())
      return intaglio_ARM_BY_PROGRAM;
  }
  return intaglio_ARM_BY_PERSON;
}

Status ArmWhenTaken(JobClient& client, const JobView& submitted, const ArmTerms& terms,
                    std::chrono::milliseconds timeout) {
  ArmOnce arm(client, submitted, terms);
  std::string awaits;
  const auto settled = [&] {
    const JobView& job = client.jobs().at(submitted.uid);
    const ArmOnce::State state = arm.Follow(job);
    awaits = arm.WhatBlockItAwaits(job);
    return state == ArmOnce::State::kArmed || state == ArmOnce::State::kLeft ||
           (job.state != intaglio_JOB_QUEUED && !awaits.empty());
  };
  if (client.PollUntil(settled, timeout)) {
    if (arm.state() == ArmOnce::State::kArmed) return {};
    if (awaits.empty()) return Fail(ErrorCode::kRefused, arm.reason());
    return Fail(ErrorCode::kRefused,
                fmt::format("job {0} is not armed by a program: its {2} may be that of "
                            "the piece before it; put its {2} into {1}, then intaglio "
                            "arm {0} (or give --same-block)",
                            submitted.number, submitted.cell, submitted.workpiece()));
  }
  const JobView& job = client.jobs().at(submitted.uid);
  if (arm.state() == ArmOnce::State::kAsked) {
    return Fail(
        ErrorCode::kTimedOut,
        fmt::format("the job service did not answer the arm of job {0}: check that "
                    "it runs (intaglio list) and whether the job is armed "
                    "(intaglio show {0})",
                    job.number));
  }
  return Fail(
      ErrorCode::kTimedOut,
      fmt::format("job {0} stays {1} and is not armed{2}: when it has its "
                  "machine and its {3} is in, run intaglio arm {0}",
                  job.number, NameOf(job.state),
                  job.message.empty() ? "" : " (" + job.message + ")", job.workpiece()));
}

}  // namespace intaglio::client
