#include "services/cell/cell_task.h"

#include <fmt/format.h>

#include <utility>

#include "engrave/core/counted.h"
#include "services/cell/pause_reason.h"
#include "services/cell/point_counts.h"
#include "services/platform/bus/error_code.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/stage/counts_at_end.h"

namespace intaglio::cell {
namespace {

using bus::View;
using Activity = WorkStates::Activity;

}  // namespace

CellTask::CellTask(host::ServiceHost& host, const std::string& cell, Maker& maker)
    : host_(host),
      maker_(maker),
      tasks_(host.bus(), bus::kEngraveTask),
      permission_(host.bus(), cell),
      publisher_(host.bus(), host.instance()) {}

void CellTask::Receive(std::chrono::nanoseconds now) {
  now_ = now;
  permission_.Receive(now);
}

GrantInputs CellTask::Inputs() const {
  return permission_.InputsFor(job_ ? job_->job_uid() : "", job_ ? job_->epoch() : 0,
                               now_);
}

bool CellTask::has_grant() const {
  return job_ && chain_.has_grant(maker_.Links(Inputs()));
}

// Once for each device that is refused; a line that comes and goes raises no more.
void CellTask::AlarmRefusal() {
  const std::string refusal = maker_.Refusal();
  if (maker_.line_up()) alarmed_refusal_.clear();
  if (refusal.empty() || refusal == alarmed_refusal_) return;
  alarmed_refusal_ = refusal;
  host_.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(ErrorCode::kRefused), refusal,
                   job_ ? job_->job_uid() : "");
}

void CellTask::ReceiveTasks() {
  AlarmRefusal();
  tasks_.Take([this](const intaglio_StageTask& task) {
    if (View(task.worker) != host_.instance()) return;
    if (task.revoked) return Revoke(task);
    const bool ours =
        job_ && View(task.job_uid) == job_->job_uid() && task.attempt == attempt_;
    if (ours) return;
    if (maker_.work() != nullptr) {
      host::LogError("job {} is refused: {} is being made", View(task.job_uid),
                     job_->job_uid());
      return;
    }
    Begin(task);
  });
}

void CellTask::Revoke(const intaglio_StageTask& task) {
  if (!job_ || View(task.job_uid) != job_->job_uid() || task.attempt != attempt_) return;
  cancelled_ = true;
  if (WorkStates* work = maker_.work()) {
    work->Stop("the job was cancelled", task.take_up);
  } else {
    End(intaglio_TASK_FAILED, intaglio_ERROR_CANCELLED, "the job was cancelled");
  }
}

void CellTask::Begin(const intaglio_StageTask& task) {
  FrozenJob job;
  const auto bytes = View(task.frozen_job);
  if (!job.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    host::LogError("the task of job {} cannot be parsed; it is ignored",
                   View(task.job_uid));
    return;
  }
  Drop();
  job_ = std::move(job);
  attempt_ = task.attempt;
  takes_up_ = task.take_up;
  cancelled_ = progress_alarmed_ = false;
  clock_ = {};
  earlier_run_count_ = 0;
  chain_.BeginJob();
  host_.SetHealth(intaglio_HEALTH_BUSY, job_->job_uid());
  if (auto begun = maker_.Begin(*job_, task); !begun) return Fail(begun.error());
  if (!task.take_up)
    publisher_.Publish({.job_uid = job_->job_uid(), .attempt = attempt_}, now_);
}

void CellTask::BeginWork(const EarlierWork& earlier, const MachineCounters& session,
                         const std::string& journal) {
  if (earlier.damaged_records > 0) {
    host_.RaiseAlarm(intaglio_ALARM_WARNING, ErrorCodeName(ErrorCode::kUnreadable),
                     fmt::format("{} of {} {} damaged: check what is in the "
                                 "machine before you resume",
                                 Counted(earlier.damaged_records, "record"), journal,
                                 IsOrAre(earlier.damaged_records)),
                     job_->job_uid());
  }
  // What an earlier process left is compared with the machine as it is now.
  if (std::exchange(takes_up_, false)) chain_.TakeUp(session);
  earlier_run_count_ = earlier.run_count;
  logged_message_.clear();
  clock_.Begin(now_);
}

void CellTask::Turn() {
  if (maker_.work() != nullptr) return TurnWork();
  WatchMachine();
}

// While nothing is there to make: an arm may have been given already.
void CellTask::WatchMachine() {
  const GrantInputs inputs = Inputs();
  const ChainLinks links = maker_.Links(inputs);
  if (!job_) return chain_.Watch(links, now_);
  (void)chain_.Turn(links, now_);
  const std::string refusal = maker_.WhyNoArmCounts();
  if (!refusal.empty()) chain_.Latch(false);
  if (inputs.grant.number == 0 || !chain_.has_lost(inputs.grant)) return;
  publisher_.Publish({.job_uid = job_->job_uid(),
                      .attempt = attempt_,
                      .state = intaglio_TASK_PAUSED,
                      .pause_reason = refusal.empty() ? PauseReasonOf(chain_.spent_by())
                                                      : intaglio_PAUSE_FAULT,
                      .message = refusal.empty() ? TextOf(chain_.spent_by())
                                                 : refusal + ", then resume"},
                     now_);
}

void CellTask::TurnWork() {
  clock_.Turn(now_, maker_.work()->activity() == Activity::kRuns, DoneCount());
  maker_.TurnWork(Inputs());
  const bool done = maker_.work()->activity() == Activity::kDone;
  if (!done || !EndWork()) PublishWork(done);
}

// False: it is made, and its end waits for what the maker still computes.
bool CellTask::EndWork() {
  const WorkStates& work = *maker_.work();
  maker_.NoteDone();
  if (leaves_ && (!work.ledger().all_ended() || work.asks())) {
    Drop();
    return true;
  }
  if (cancelled_) {
    End(intaglio_TASK_FAILED, intaglio_ERROR_CANCELLED, std::string(work.message()));
    return true;
  }
  if (!maker_.PendingAtEnd().empty()) return false;
  End(intaglio_TASK_DONE, intaglio_ERROR_NONE, "");
  return true;
}

void CellTask::PublishWork(bool done) {
  const WorkStates& work = *maker_.work();
  const bool waits = !done && work.waits();
  TaskReport report{.job_uid = job_->job_uid(), .attempt = attempt_};
  report.state = waits ? intaglio_TASK_PAUSED : intaglio_TASK_RUNNING;
  report.counts = CountsOf(work.ledger());
  report.done_count = DoneCount();
  report.total_count = work.ledger().size();
  report.elapsed_s = clock_.ElapsedSeconds(DoneCount());
  report.estimate_ticks = maker_.estimate_ticks();
  if (waits) {
    report.pause_reason = PauseReasonOf({.faulted = work.faulted(),
                                         .lost_a_line = work.lost_a_line(),
                                         .asks = work.asks(),
                                         .spent_by = chain_.spent_by()});
  }
  report.alarm = done ? "" : work.alarm();
  RaiseNoProgress(report.alarm);
  report.message = done ? maker_.PendingAtEnd() : work.message();
  if (report.message != logged_message_) {
    logged_message_ = report.message;
    if (!logged_message_.empty()) host::LogInfo("{}", logged_message_);
  }
  publisher_.Publish(report, now_);
}

// Once, when the progress stops; the task has the newest figures.
void CellTask::RaiseNoProgress(const std::string& alarm) {
  if (!alarm.empty() && !progress_alarmed_) {
    host_.RaiseAlarm(intaglio_ALARM_WARNING, "no_progress", alarm, job_->job_uid());
  }
  progress_alarmed_ = !alarm.empty();
}

std::uint64_t CellTask::DoneCount() {
  if (maker_.work() == nullptr) return 0;
  const intaglio_PointCounts counts = CountsOf(maker_.work()->ledger());
  return counts.made + counts.missed;
}

EngraveOutcome CellTask::Outcome() {
  EngraveOutcome outcome;
  const WorkStates& work = *maker_.work();
  const intaglio_PointCounts counts = AtEnd(CountsOf(work.ledger()));
  outcome.set_planned_count(counts.planned);
  outcome.set_made_count(counts.made);
  outcome.set_missed_count(counts.missed);
  outcome.set_skipped_count(counts.skipped);
  outcome.set_uncertain_count(counts.uncertain);
  outcome.set_run_count(earlier_run_count_ + work.run_count());
  outcome.set_settled_by_memory_count(work.settled_by_memory_count());
  maker_.AddTo(outcome);
  return outcome;
}

void CellTask::Fail(const Error& error) {
  End(intaglio_TASK_FAILED, bus::WireOf(error.code), error.message);
}

void CellTask::End(intaglio_TaskState state, intaglio_ErrorCode code,
                   const std::string& message) {
  TaskReport report{.job_uid = job_->job_uid(), .attempt = attempt_, .state = state};
  report.elapsed_s = clock_.ElapsedSeconds(DoneCount());
  report.estimate_ticks = maker_.estimate_ticks();
  report.error_code = code;
  report.message = message;
  StageOutcome outcome;
  outcome.set_elapsed_s(report.elapsed_s);
  if (const WorkStates* work = maker_.work()) {
    *outcome.mutable_engrave() = Outcome();
    report.counts = AtEnd(CountsOf(work->ledger()));
    report.total_count = work->ledger().size();
    report.done_count = DoneCount();
  }
  report.outcome = outcome.SerializeAsString();
  Drop();
  maker_.NoteEnd(report.job_uid, state == intaglio_TASK_DONE);
  publisher_.Publish(report, now_);
  host_.SetHealth(intaglio_HEALTH_READY);
}

void CellTask::Stop(const std::string& why) {
  leaves_ = true;
  if (WorkStates* work = maker_.work()) {
    work->Stop(why, false);
  } else if (job_) {
    Drop();
  }
}

void CellTask::Drop() {
  maker_.Drop();
  job_.reset();
}

}  // namespace intaglio::cell
