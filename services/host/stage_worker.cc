#include "services/host/stage_worker.h"

#include <spdlog/spdlog.h>

#include <thread>

#include "services/bus/samples.h"

namespace intaglio::host {
namespace {
using bus::View;
// Shorter than the period of the health, which the loop itself keeps fresh.
constexpr std::chrono::milliseconds kTurnPeriod{50};
constexpr std::chrono::milliseconds kShortestTurn{1};
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
  const std::string job_uid(View(sample.job_uid));
  if (sample.revoked) {
    if (pending_ && pending_->task.SameAs(job_uid, sample.attempt)) pending_.reset();
    if (task_.SameAs(job_uid, sample.attempt)) {
      Withdraw(ErrorCode::kCancelled, "the task was revoked");
    }
    return;
  }
  if (task_.SameAs(job_uid, sample.attempt)) return;  // told again
  Withdraw(ErrorCode::kCancelled, "a newer task was given");
  const auto bytes = View(sample.frozen_job);
  pending_ = {{job_uid, sample.attempt, {}, std::string(View(sample.consumer))},
              std::string(bytes.begin(), bytes.end())};
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
  spdlog::info("job {} attempt {}: accepted", task_.job_uid, task_.attempt);
  host_.SetHealth(intaglio_HEALTH_BUSY, task_.job_uid);
  reporter_.Accept(task_.job_uid, task_.attempt, now_);
  const auto opened =
      readable ? input_.Open(task_)
               : Fail(ErrorCode::kUnreadable,
                      "the task cannot be read: the job service is of another version");
  if (!opened) EndTask(intaglio_TASK_FAILED, opened.error());
}

Result<bool> StageWorker::Advance() {
  if (phase_ == Phase::kIdle) return false;
  progress_.elapsed_s = std::chrono::duration<double>(now_ - began_at_).count();
  switch (phase_) {
    case Phase::kIdle:
      break;
    case Phase::kInput: {
      const auto complete = input_.Poll();
      if (!complete) return tl::unexpected(complete.error());
      if (*complete) {
        computation_ = std::make_unique<Computation<StageResult>>(
            input_.TakeComputation(task_), wake_);
        phase_ = Phase::kComputing;
      }
      break;
    }
    case Phase::kComputing:
      progress_.done_count = computation_->done();
      progress_.total_count = computation_->total();
      if (computation_->ready()) return FinishComputing();
      break;
    case Phase::kSending:
      return output_.Advance(now_);
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
  input_.Close();
  output_.End();
  if (state == intaglio_TASK_DONE) {
    spdlog::info("job {} attempt {}: done, {} points in {:.2f} s", task_.job_uid,
                 task_.attempt, progress_.done_count, progress_.elapsed_s);
    reporter_.Done(progress_, outcome_);
  } else {
    spdlog::warn("job {} attempt {}: {}: {}", task_.job_uid, task_.attempt,
                 ErrorCodeName(error.code), error.message);
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
    const auto began = std::chrono::steady_clock::now();
    worker.Turn(began);
    host.KeepAlive();
    (void)wait.Wait(kTurnPeriod);
    // Samples of a stream that is not read now, as while computing, end every wait.
    std::this_thread::sleep_until(began + kShortestTurn);
  }
  worker.Stop();
  return 0;
}

}  // namespace intaglio::host
