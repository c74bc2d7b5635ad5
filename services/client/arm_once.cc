#include "services/client/arm_once.h"

#include <fmt/format.h>

namespace intaglio::client {

ArmOnce::State ArmOnce::Follow(const JobView& job) {
  if (state_ == State::kAsked) TakeAnswer();
  if (state_ != State::kWaits) return state_;
  if (job.ended() || job.armed) {
    state_ = State::kArmed;
  } else if (job.disarm_count != disarm_count_) {
    Leave(job.disarm_reason);
  } else if (job.state == intaglio_JOB_PAUSED) {
    Leave(job.message);
  } else if (job.state != intaglio_JOB_QUEUED) {
    Ask(job);
  }
  return state_;
}

void ArmOnce::Ask(const JobView& job) {
  const auto sent = client_->Send(
      job, {.kind = intaglio_COMMAND_ARM, .accept_breakage = accept_breakage_});
  if (!sent) return Leave(sent.error().message);
  asked_ = *sent;
  state_ = State::kAsked;
}

void ArmOnce::TakeAnswer() {
  const auto answer = client_->AnswerTo(asked_);
  if (!answer) return;
  if (answer->taken()) {
    state_ = State::kArmed;
  } else if (answer->code == intaglio_ANSWER_NOT_YET) {
    state_ = State::kWaits;  // it lost its machine before the command came
  } else {
    Leave(answer->message);
  }
}

void ArmOnce::Leave(const std::string& reason) {
  state_ = State::kLeft;
  reason_ = reason;
}

Status ArmWhenTaken(JobClient& client, const JobView& submitted, bool accept_breakage,
                    std::chrono::milliseconds timeout) {
  ArmOnce arm(client, submitted, accept_breakage);
  const auto settled = [&] {
    const ArmOnce::State state = arm.Follow(client.jobs().at(submitted.uid));
    return state == ArmOnce::State::kArmed || state == ArmOnce::State::kLeft;
  };
  if (client.PollUntil(settled, timeout)) {
    if (arm.state() == ArmOnce::State::kArmed) return {};
    return Fail(ErrorCode::kRefused, arm.reason());
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
  return Fail(ErrorCode::kTimedOut,
              fmt::format("job {0} stays {1} and is not armed{2}: when it has its "
                          "machine and its block is in, run intaglio arm {0}",
                          job.number, NameOf(job.state),
                          job.message.empty() ? "" : " (" + job.message + ")"));
}

}  // namespace intaglio::client
