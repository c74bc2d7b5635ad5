#include "services/job_service/job_service.h"

#include <fmt/format.h>

#include "proto/task.pb.h"
#include "services/job/model_kind.h"
#include "services/job_service/submission.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::job_service {
namespace {

using bus::Borrow;
using bus::View;

std::vector<std::uint8_t> BytesOf(const std::string& text) {
  return {text.begin(), text.end()};
}

TaskView ViewOf(const intaglio_TaskStatus& status) {
  TaskView view;
  view.task = {std::string(View(status.job_uid)), status.attempt, status.part,
               status.part_attempt};
  view.stage = status.stage;
  view.worker = View(status.worker);
  view.state = status.state;
  view.done_count = status.done_count;
  view.total_count = status.total_count;
  view.elapsed_s = status.elapsed_s;
  view.estimate_ticks = status.estimate_ticks;
  view.error_code = status.error_code;
  view.pause_reason = status.pause_reason;
  view.message = View(status.message);
  return view;
}

FrozenJob FrozenOf(const JobRecord& job) {
  FrozenJob frozen;
  if (!frozen.ParseFromString(job.frozen_job)) {
    throw StoreError(fmt::format("job {} in the database is not readable", job.uid),
                     false);
  }
  return frozen;
}

}  // namespace

JobService::JobService(host::ServiceHost& host, const JobServiceOptions& options,
                       Nanoseconds now)
    : options_(options),
      store_(options.database),
      reader_(ReadingWith(options.materials)),
      statistics_(store_, options.recording.string()),
      epoch_(store_.BeginRun()),
      submissions_(host.bus(), bus::kJobSubmission),
      commands_(host.bus(), store_),
      reports_(host.bus()),
      statuses_(host.bus(), bus::kJobStatus),
      discretize_tasks_(host.bus(), bus::kDiscretizeTask),
      sort_tasks_(host.bus(), bus::kSortTask),
      engrave_tasks_(host.bus(), bus::kEngraveTask),
      permissions_(host.bus()),
      seen_(options_.database.string() + ".seen"),
      feed_(host.bus()),
      queue_(*this) {
  queue_.Restore(store_.Load(kRememberedJobs), seen_.absence(), now);
  for (const std::string& cell : CellsInUse()) OpenCell(cell);
  // What a cancelled job has left in the glass may still be reported.
  for (const auto& [uid, job] : queue_.jobs()) reports_.OpenCell(job.cell);
}

JobService::~JobService() = default;

void JobService::OpenCell(const std::string& cell) {
  permissions_.Open(cell, CellsInUse());
  reports_.OpenCell(cell);
}

// Tasks before health: a worker's last report counts before its absence.
void JobService::Turn(Nanoseconds now) {
  TakeTasks(now);
  TakeHealth(now);
  TakeSubmissions(now);
  commands_.Take([&](const CommandView& command) { return queue_.Take(command, now); },
                 now);
  for (const ModelFeed::Failure& failure : feed_.TakeFailures()) {
    queue_.FeedFailed(failure.job_uid, failure.attempt, failure.message, now);
  }
  for (const auto& [cell, pressed] : permissions_.TakeStops()) {
    queue_.SetStop(cell, pressed, now);
  }
  queue_.Turn(now);
  seen_.Note();
  permissions_.Decide(queue_.Permissions(now));
}

void JobService::Close(Nanoseconds now) {
  queue_.Close(now);
  permissions_.Decide(queue_.Permissions(now));
}

void JobService::TakeTasks(Nanoseconds now) {
  const auto take = [&](const intaglio_TaskStatus& status) {
    const TaskView view = ViewOf(status);
    if (view.stage > intaglio_STAGE_ENGRAVE) return;
    bool fresh = false;
    if (view.ended() && !queue_.AnswersAnOldRevocation(view)) {
      const auto bytes = View(status.outcome);
      fresh = store_.KeepTaskEnd(view, std::string(bytes.begin(), bytes.end()));
    }
    const JobRecord* job = queue_.Find(view.task.job_uid);
    const bool had_ended = job != nullptr && job->ended();
    queue_.Take(view, now);
    // What a job that was ended from outside has left in the glass comes afterwards,
    // maybe when the queue has forgotten the job.
    if (!view.ended() || view.stage != intaglio_STAGE_ENGRAVE) return;
    if (had_ended) {
      statistics_.Ended(*job);
    } else if (job == nullptr && fresh) {
      const auto past = store_.LoadEnded(view.task.job_uid);
      if (past) statistics_.Ended(*past);
    }
  };
  reports_.TakeTasks(take, now);
}

void JobService::TakeHealth(Nanoseconds now) {
  const auto take = [&](const intaglio_ServiceHealth& health, bool alive) {
    WorkerView view;
    view.instance = View(health.instance);
    if (!alive) return queue_.WorkerLost(view.instance, now);
    view.role = health.role;
    view.state = health.state;
    view.cell = View(health.cell);
    view.message = View(health.message);
    queue_.Take(view, now);
  };
  reports_.TakeHealth(take, now);
}

// ---- What the queue decides ---------------------------------------------------------

void JobService::Changed(const JobRecord& job) {
  store_.Keep(job);
  Publish(job);
  if (job.ended()) {
    statistics_.Ended(job);
  } else {
    statistics_.Changed(job);
  }
}

void JobService::Progressed(const JobRecord& job) {
  Publish(job);
  statistics_.Progressed(job);
}

void JobService::PublishFault(const std::string& why) {
  for (const auto& [uid, job] : queue_.jobs()) {
    if (!job.active()) continue;
    JobRecord faulted = job;
    if (faulted.state == intaglio_JOB_ENGRAVING) {
      faulted.state = intaglio_JOB_PAUSED;
      faulted.pause_reason = intaglio_PAUSE_FAULT;
    }
    faulted.message = why;
    ++faulted.revision;
    Publish(faulted);
  }
}

void JobService::Publish(const JobRecord& job) {
  std::vector<intaglio_StageProgress> progress;
  for (const intaglio_Stage stage : kStages) {
    const StageRecord& record = job.stage(stage);
    progress.push_back({stage, record.done_count, record.total_count, record.elapsed_s});
  }
  intaglio_JobStatus sample{};
  sample.job_uid = Borrow(job.uid);
  sample.submission_uid = Borrow(job.submission_uid);
  sample.epoch = job.epoch;
  sample.number = job.number;
  sample.name = Borrow(job.name);
  sample.state = job.state;
  sample.pause_reason = job.pause_reason;
  sample.attempt = job.attempt;
  Borrow(sample.progress, progress);
  sample.estimate_ticks = job.estimate_ticks;
  sample.rate_hz = job.rate_hz;
  sample.message = Borrow(job.message);
  sample.result_directory = Borrow(job.result_directory);
  sample.cell = Borrow(job.cell);
  sample.revision = job.revision;
  sample.speed_percent = job.speed_percent;
  sample.armed = job.arm.armed();
  sample.last_command = job.arm.kept().last_command;
  sample.disarm_count = job.arm.disarm_count();
  sample.disarm_reason = Borrow(job.arm.disarm_reason());
  if (auto written = statuses_.Write(sample); !written) {
    host::LogWarning("status of job {}: {}", job.uid, written.error().message);
  }
}

void JobService::Give(const TaskOrder& order, const JobRecord& job) {
  store_.KeepTask(order);
  const std::vector<std::uint8_t> frozen =
      order.revoked ? std::vector<std::uint8_t>() : BytesOf(job.frozen_job);
  intaglio_StageTask sample{};
  sample.worker = Borrow(order.worker);
  sample.epoch = epoch_;
  sample.job_uid = Borrow(order.task.job_uid);
  sample.attempt = order.task.attempt;
  sample.stage = order.stage;
  const auto part_count = static_cast<std::uint32_t>(job.parts.size());
  sample.part = order.task.part;
  sample.part_count = order.stage == intaglio_STAGE_DISCRETIZE ? part_count : 1;
  sample.part_attempt = order.task.part_attempt;
  sample.input_part_count = order.stage == intaglio_STAGE_SORT ? part_count : 1;
  sample.revoked = order.revoked;
  sample.take_up = order.take_up;
  Borrow(sample.frozen_job, frozen);
  sample.consumer = Borrow(order.consumer);
  bus::Writer<intaglio_StageTask>& writer =
      order.stage == intaglio_STAGE_DISCRETIZE ? discretize_tasks_
      : order.stage == intaglio_STAGE_SORT     ? sort_tasks_
                                               : engrave_tasks_;
  if (order.stage == intaglio_STAGE_DISCRETIZE && !order.revoked) StartFeed(order, job);
  host::LogInfo("job {}, attempt {}, part {}.{}: {} {}", order.task.job_uid,
                order.task.attempt, order.task.part, order.task.part_attempt,
                order.revoked ? "revoked from" : "given to", order.worker);
  if (auto written = writer.Write(sample); !written) {
    // A worker that does not answer costs the attempt (queue/job_queue.h).
    host::LogWarning("task of {}: {}", order.worker, written.error().message);
  }
}

void JobService::StartFeed(const TaskOrder& order, const JobRecord& job) {
  feed_.Start(order.task, FilesOf(FrozenOf(job).job()));
}

void JobService::StopFeed(const std::string& job_uid) { feed_.Stop(job_uid); }

void JobService::Forgotten(const JobRecord& job) {
  Withdraw(job.uid, job.submission_uid);
}

// The instance of a synchronizer stays: it takes no dispose for a revocation, and it may
// have a job in hand when it is back. It is small, or one of few.
void JobService::WorkerForgotten(const std::string& instance) {
  const std::string empty;
  intaglio_StageTask sample{};
  sample.worker = Borrow(instance);
  sample.job_uid = sample.consumer = Borrow(empty);
  (void)discretize_tasks_.Dispose(sample);
  (void)sort_tasks_.Dispose(sample);
}

std::set<std::string> JobService::CellsInUse() const {
  std::set<std::string> cells;
  for (const auto& [uid, job] : queue_.jobs()) {
    if (!job.ended()) cells.insert(job.cell);
  }
  return cells;
}

void JobService::Withdraw(const std::string& job_uid, const std::string& submission_uid) {
  intaglio_JobStatus sample{};
  sample.job_uid = Borrow(job_uid);
  sample.submission_uid = Borrow(submission_uid);
  const std::string empty;
  sample.name = sample.message = sample.result_directory = sample.cell = Borrow(empty);
  if (auto disposed = statuses_.Dispose(sample); !disposed) {
    host::LogWarning("end of the status of job {}: {}", job_uid,
                     disposed.error().message);
  }
}

}  // namespace intaglio::job_service
