#include "services/platform/host/stage/stage_worker.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::host {
namespace {
using bus::View;
// Shorter than the period of the health, which the loop itself keeps fresh.
constexpr std::chrono::milliseconds kTurnPeriod{50};
constexpr std::chrono::milliseconds kReportPeriod{100};
// Made and not sent yet, before the next one is begun.
constexpr std::size_t kMaxUnsent = 1;

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
  Advance();
  if (works_.empty() && pending_) {
    Accept(*std::exchange(pending_, std::nullopt));
    wake_();
  }
}

void StageWorker::Stop() {
  pending_.reset();
  const Error stopped{ErrorCode::kCancelled, "the service was stopped", ""};
  while (!works_.empty()) End(0, &stopped);
}

void StageWorker::TakeTasks() {
  tasks_.TakeAll(
      [this](const intaglio_StageTask& sample, const bus::SampleOrigin& origin) {
        if (View(sample.worker) != host_.instance()) return;
        if (origin.alive) return Receive(sample);
        pending_.reset();
        Withdraw(ErrorCode::kLinkLost,
                 "the job service that assigned the task no longer runs");
      });
}

void StageWorker::Receive(const intaglio_StageTask& sample) {
  StageTask task = TaskOf(sample);
  if (sample.revoked) return Revoke(task);
  if (newest_ && newest_->SameAs(task)) return;  // received again
  newest_ = task;
  const auto bytes = View(sample.frozen_job);
  Work work;
  work.task = std::move(task);
  work.frozen_job.assign(bytes.begin(), bytes.end());
  const bool joins =
      !works_.empty() && !withdrawn_ && !pending_ && work.task.part.may_be_made() &&
      std::all_of(works_.begin(), works_.end(), [&work](const Work& other) {
        return other.task.IsOfChain(work.task) &&
               other.task.part.index != work.task.part.index;
      });
  if (joins) return Accept(std::move(work));
  Withdraw(ErrorCode::kCancelled, "a newer task was assigned");
  pending_ = std::move(work);
}

void StageWorker::Revoke(const StageTask& task) {
  if (pending_ && pending_->task.IsOfChain(task)) pending_.reset();
  if (!works_.empty() && works_.front().task.IsOfChain(task)) {
    Withdraw(ErrorCode::kCancelled, "the task was revoked");
  }
}

void StageWorker::Withdraw(ErrorCode code, const std::string& reason) {
  if (works_.empty() || withdrawn_) return;
  withdrawn_ = Error{code, reason, ""};
  if (computation_) computation_->Cancel();
  output_.End();
}

void StageWorker::Accept(Work work) {
  LogInfo("{}: accepted", NameOf(work.task));
  host_.SetHealth(intaglio_HEALTH_BUSY, work.task.job_uid);
  reporter_.Accept(work.task);
  work.reported_at = now_;
  works_.push_back(std::move(work));
}

void StageWorker::Advance() {
  auto taken = input_.Poll(now_);
  const auto sent = output_.Advance(now_);
  if (works_.empty()) return;
  if (withdrawn_) return EndWithdrawn();
  while (Make(taken)) {
  }
  while (Send(sent)) {
  }
  while (Make(taken)) {  // the next one, when this has made room
  }
  for (Work& work : works_) Report(work);
}

void StageWorker::EndWithdrawn() {
  if (computation_ && !computation_->ready()) return;
  while (!works_.empty()) End(0, &*withdrawn_);
  withdrawn_.reset();
}

bool StageWorker::Make(Result<bool>& taken) {
  const auto next = std::find_if(works_.begin(), works_.end(), [](const Work& work) {
    return work.phase < Phase::kMade;
  });
  const auto place = static_cast<std::size_t>(next - works_.begin());
  if (next == works_.end() || (next->phase == Phase::kWaiting && place > kMaxUnsent)) {
    return false;
  }
  const auto made = MakeOne(*next, taken);
  if (!made) End(place, &made.error());
  return !made || *made;
}

Result<bool> StageWorker::MakeOne(Work& work, Result<bool>& taken) {
  if (work.phase == Phase::kWaiting) {
    INTAGLIO_TRY(Begin(work));
    taken = input_.Poll(now_);  // it may be there already
  }
  work.progress.elapsed_s = std::chrono::duration<double>(now_ - work.began_at).count();
  if (work.phase == Phase::kInput) {
    if (!taken || !*taken) return taken;
    computation_ = std::make_unique<Computation<StageResult>>(
        input_.TakeComputation(work.task), wake_);
    work.phase = Phase::kComputing;
  }
  work.progress.done_count = computation_->done();
  work.progress.total_count = computation_->total();
  work.progress.estimate_ticks = input_.estimate_ticks();
  if (!computation_->ready()) return false;
  INTAGLIO_TRY(FinishComputing(work));
  return true;
}

Status StageWorker::Begin(Work& work) {
  work.began_at = now_;
  const bool readable = work.task.job.ParseFromString(work.frozen_job);
  work.frozen_job.clear();
  work.phase = Phase::kInput;
  if (readable && work.task.part.may_be_made()) return input_.Open(work.task);
  return Fail(ErrorCode::kUnreadable,
              "the task cannot be parsed: the job service has another version");
}

Status StageWorker::FinishComputing(Work& work) {
  auto result = computation_->Take();
  computation_.reset();
  if (!result) return tl::unexpected(result.error());
  input_.Close(false, now_);
  work.task.job.Clear();
  work.result = std::move(*result);
  work.progress.done_count = work.progress.total_count = work.result.size();
  work.phase = Phase::kMade;
  return {};
}

bool StageWorker::Send(const Result<bool>& sent) {
  if (works_.empty()) return false;
  Work& work = works_.front();
  if (work.phase < Phase::kMade) return false;
  work.progress.elapsed_s = std::chrono::duration<double>(now_ - work.began_at).count();
  Result<bool> all_sent = sent;
  const bool is_sent =
      !work.task.consumer.empty() && !IsComparison(work.task.part.attempt);
  if (work.phase == Phase::kMade && is_sent) {
    StageResult made;
    made.cloud = std::exchange(work.result.cloud, {});
    made.marks = std::exchange(work.result.marks, {});
    output_.Begin(work.task, std::move(made), now_);
    work.phase = Phase::kSending;
    all_sent = output_.Advance(now_);
  } else if (work.phase == Phase::kMade) {
    all_sent = true;
  }
  if (all_sent && !*all_sent) return false;
  End(0, all_sent ? nullptr : &all_sent.error());
  return true;
}

void StageWorker::Report(Work& work) {
  const bool begun = work.phase != Phase::kWaiting;
  if (!begun || now_ - work.reported_at < kReportPeriod) return;
  work.reported_at = now_;
  reporter_.Run(work.task, work.progress);
}

void StageWorker::End(std::size_t place, const Error* error) {
  Work work = std::move(works_.at(place));
  works_.erase(works_.begin() + static_cast<std::ptrdiff_t>(place));
  if (work.phase == Phase::kInput || work.phase == Phase::kComputing) {
    computation_.reset();
    input_.Close(withdrawn_.has_value(), now_);
  } else if (withdrawn_) {
    input_.Close(true, now_);
  }
  if (work.phase == Phase::kSending) output_.End();
  if (error == nullptr) {
    LogInfo("{}: done, {} made in {:.2f} s", NameOf(work.task), work.progress.done_count,
            work.progress.elapsed_s);
    reporter_.Done(work.task, work.progress, std::move(work.result.outcome));
  } else {
    LogWarning("{}: {}: {}", NameOf(work.task), ErrorCodeName(error->code),
               error->message);
    reporter_.Failed(work.task, work.progress, *error);
  }
  if (works_.empty()) host_.SetHealth(intaglio_HEALTH_READY);
}

int RunStageWorker(ServiceHost& host, bus::WaitSet& wait, StageWorker& worker) {
  wait.Attach(worker.tasks());
  GiveWay();
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
