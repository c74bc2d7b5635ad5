#include "services/host/stage_worker.h"

#include "services/bus/samples.h"
#include "services/host/log.h"

namespace intaglio::host {
namespace {
using bus::View;
// Shorter than the period of the health, which the loop itself keeps fresh.
constexpr std::chrono::milliseconds kTurnPeriod{50};

/// All but the job.
StageTask TaskOf(const intaglio_StageTask& sample) {
  return {std::string(View(sample.job_uid)),
          sample.attempt,
          {sample.part, sample.part_count, sample.part_attempt},
          sample.input_part_count,
          {},
          std::string(View(sample.consumer))};
}

std::string NameOf(const StageTask& task) {
  const std::string name = fmt::format("job {} attempt {}", task.job_uid, task.attempt);
  if (task.part.count == 1) return name;
  return fmt::format("{} part {} of {}", name, task.part.index + 1, task.part.count);
}
}  // namespace

StageWorker::StageWorker(ServiceHost& host, const bus::Topic<intaglio_StageTask>& tasks,
                         intaglio_Stage stage, StageInput& input, StageOutput& output,
                         std::function<void()> wake)
    : host_(host),
      tasks_(host.bus(), tasks),
      reporter_(host.bus(), host.instance(), stage),
      input_(input),
      output_(output),
      wake_(std::move(wake)) {}

StageWorker::~StageWorker() = default;

void StageWorker::Turn(TimePoint now) {
  now_ = now;
  TakeTasks();
  const auto advanced = Advance();
  if (!advanced) {
    EndTask(intaglio_TASK_FAILED, withdrawn_.value_or(advanced.error()));
  } else if (*advanced) {
    EndTask(intaglio_TASK_DONE, {});
  }
  if (phase_ == Phase::kIdle && pending_) BeginPending();
}

void StageWorker::Stop() {
  pending_.reset();
  if (phase_ == Phase::kIdle) return;
  EndTask(intaglio_TASK_FAILED, {ErrorCode::kCancelled, "the service was stopped", ""});
}

void StageWorker::TakeTasks() {
  tasks_.TakeAll(
      [this](const intaglio_StageTask& sample, const bus::SampleOrigin& origin) {
        if (View(sample.worker) != host_.instance()) return;
        if (origin.alive) return Take(sample);
        pending_.reset();
        Withdraw(ErrorCode::kLinkLost, "the job service that gave the task is gone");
      });
}

void StageWorker::Take(const intaglio_StageTask& sample) {
  StageTask task = TaskOf(sample);
  if (sample.revoked) {
    if (pending_ && pending_->task.SameAs(task)) pending_.reset();
    if (task_.SameAs(task)) Withdraw(ErrorCode::kCancelled, "the task was revoked");
    return;
  }
  if (task_.SameAs(task)) return;  // told again
  Withdraw(ErrorCode::kCancelled, "a newer task was given");
  const auto bytes = View(sample.frozen_job);
  pending_ = {std::move(task), std::string(bytes.begin(), bytes.end())};
}

void StageWorker::Withdraw(ErrorCode code, const std::string& reason) {
  if (phase_ == Phase::kIdle || withdrawn_) return;
  withdrawn_ = Error{code, reason, ""};
  if (computation_) computation_->Cancel();
  phase_ = Phase::kCancelling;
}

void StageWorker::BeginPending() {
  task_ = std::move(pending_->task);
  const bool readable = task_.job.ParseFromString(pending_->frozen_job);
  pending_.reset();
  began_at_ = now_;
  progress_ = {};
  outcome_ = {};
  phase_ = Phase::kInput;
  LogInfo("{}: accepted", NameOf(task_));
  host_.SetHealth(intaglio_HEALTH_BUSY, task_.job_uid);
  reporter_.Accept(task_.job_uid, task_.attempt, task_.part, now_);
  const auto opened = OpenInput(readable && task_.part.valid());
  if (!opened) EndTask(intaglio_TASK_FAILED, opened.error());
}

Status StageWorker::OpenInput(bool readable) {
  if (readable) return input_.Open(task_);
  return Fail(ErrorCode::kUnreadable,
              "the task cannot be read: the job service is of another version");
}

Result<bool> StageWorker::Advance() {
  const auto taken = input_.Poll(now_);
  const auto sent = output_.Advance(now_);
  if (phase_ == Phase::kIdle) return false;
  progress_.elapsed_s = std::chrono::duration<double>(now_ - began_at_).count();
  switch (phase_) {
    case Phase::kIdle:
      break;
    case Phase::kInput:
      if (!taken) return tl::unexpected(taken.error());
      if (*taken) {
        computation_ = std::make_unique<Computation<StageResult>>(
            input_.TakeComputation(task_), wake_);
        phase_ = Phase::kComputing;
      }
      break;
    case Phase::kComputing:
      progress_.done_count = computation_->done();
      progress_.total_count = computation_->total();
      if (computation_->ready()) return FinishComputing();
      break;
    case Phase::kSending:
      if (!sent || *sent) return sent;
      break;
    case Phase::kCancelling:
      if (!computation_ || computation_->ready()) return tl::unexpected(*withdrawn_);
      break;
  }
  reporter_.Run(progress_, now_);
  return false;
}

Result<bool> StageWorker::FinishComputing() {
  auto result = computation_->Take();
  computation_.reset();
  if (!result) return tl::unexpected(result.error());
  outcome_ = std::move(result->outcome);
  progress_.done_count = progress_.total_count = result->cloud.size();
  reporter_.Run(progress_, now_);
  if (task_.consumer.empty()) return true;
  output_.Begin(task_, std::move(result->cloud), now_);
  phase_ = Phase::kSending;
  return output_.Advance(now_);
}

void StageWorker::EndTask(intaglio_TaskState state, const Error& error) {
  computation_.reset();
  input_.Close(withdrawn_.has_value(), now_);
  output_.End();
  if (state == intaglio_TASK_DONE) {
    LogInfo("{}: done, {} points in {:.2f} s", NameOf(task_), progress_.done_count,
            progress_.elapsed_s);
    reporter_.Done(progress_, outcome_);
  } else {
    LogWarning("{}: {}: {}", NameOf(task_), ErrorCodeName(error.code), error.message);
    reporter_.Failed(progress_, error);
  }
  withdrawn_.reset();
  phase_ = Phase::kIdle;
  host_.SetHealth(intaglio_HEALTH_READY);
}

int RunStageWorker(ServiceHost& host, bus::WaitSet& wait, StageWorker& worker) {
  wait.Attach(worker.tasks());
  host.SetHealth(intaglio_HEALTH_READY);
  while (!host.stopping()) {
    worker.Turn(std::chrono::steady_clock::now());
    host.KeepAlive();
    (void)wait.Wait(kTurnPeriod);
  }
  worker.Stop();
  return 0;
}

}  // namespace intaglio::host
