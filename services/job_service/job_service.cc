#include "services/job_service/job_service.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "proto/task.pb.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/job_kind.h"
#include "services/job/marks/mark_maker.h"
#include "services/job/verdict/warnings.h"
#include "services/job_service/submission.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/times/utc_time.h"

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
  view.counts = status.counts;
  view.alarm = View(status.alarm);
  return view;
}

/// Empty: it has none.
std::string ChecksumIn(const std::string& bytes) {
  StageOutcome outcome;
  return outcome.ParseFromString(bytes) ? outcome.discretize().checksum() : "";
}

/// A permission with a partition's pattern would reach other machines, too.
bool IsCellName(const std::string& cell) {
  return !cell.empty() && std::all_of(cell.begin(), cell.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
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
                       JobStore store, const std::optional<SeenByStandby>& standby,
                       StatusBoard& board, Nanoseconds now)
    : host_(host),
      options_(options),
      store_(std::move(store)),
      reader_(ReadingWith(options.materials)),
      statistics_(store_, options.recording.string()),
      epoch_(store_.BeginRun()),
      submissions_(host.bus(), bus::kJobSubmission),
      manual_commands_(host.bus(), bus::kManualCommand),
      commands_(host.bus(), store_),
      reports_(host.bus()),
      board_(board),
      discretize_tasks_(host.bus(), bus::kDiscretizeTask),
      sort_tasks_(host.bus(), bus::kSortTask),
      engrave_tasks_(host.bus(), bus::kEngraveTask),
      permissions_(host.bus()),
      interlocks_(host.bus()),
      seen_({[this] { return store_.Note(); },
             [this](const std::string& text) { store_.KeepNote(text); }},
            standby),
      feed_(host.bus()),
      queue_(*this),
      now_(now) {
  const auto pieces = store_.LoadPieces();
  for (const PieceRecord& piece : pieces) interlocks_.OpenCell(piece.cell);
  queue_.RestoreCells(pieces, store_.LoadLoadedBlocks(), store_.LoadMounts());
  queue_.RestoreLeftOut(store_.LoadLeftOut(), now);
  for (const auto& [cell, mount] : queue_.mounts().mounts()) board_.Publish(mount);
  std::vector<JobRecord> restored = store_.Load(kRememberedJobs);
  std::set<std::string> announced;
  for (const JobRecord& job : restored) announced.insert(job.uid);
  board_.Announce(announced);
  queue_.Restore(std::move(restored), seen_.absence(), now);
  for (const std::string& cell : CellsInUse()) OpenCell(cell);
  // What a cancelled job has left in the glass may still be reported.
  std::set<std::string> known;
  for (const auto& [uid, job] : queue_.jobs()) {
    reports_.OpenCell(job.cell);
    known.insert(uid);
    if (job.ended() && store_.ResultOf(uid).verdict.empty()) unsettled_.Add(uid, now);
  }
  board_.WithdrawAllBut(known);
}

JobService::~JobService() = default;

void JobService::OpenCell(const std::string& cell) {
  permissions_.Open(cell, CellsInUse());
  reports_.OpenCell(cell);
  interlocks_.OpenCell(cell);
}

// Tasks before health: a worker's last report counts before its absence.
void JobService::Turn(Nanoseconds now) {
  now_ = now;
  TakeTasks(now);
  TakeHealth(now);
  TakeSubmissions(now);
  TakeManualCommands();
  for (const InterlockReport& report : interlocks_.Take()) {
    queue_.SetDoor(report.cell, report.door);
    permissions_.TakePresses(report.cell, report.stops_held);
  }
  commands_.Take([&](const CommandView& command) { return TakeCommand(command, now); },
                 now);
  for (const ModelFeed::Failure& failure : feed_.TakeFailures()) {
    queue_.FeedFailed(failure.job_uid, failure.attempt, failure.message, now);
  }
  for (const auto& [cell, pressed] : permissions_.TakeStops()) {
    queue_.SetStop(cell, pressed, now);
  }
  queue_.Turn(now);
  for (const std::string& uid : unsettled_.TakeOverdue(now)) {
    if (const JobRecord* job = queue_.Find(uid)) Settle(*job, false);
  }
  seen_.Note();
  permissions_.Decide(queue_.Permissions(now));
  ReportRemarks();
}

// In the health, which `intaglio status` and the console show; each as an alarm once.
void JobService::ReportRemarks() {
  std::vector<std::string> remarks = queue_.Remarks();
  if (std::string flood = commands_.Remark(now_); !flood.empty())
    remarks.push_back(std::move(flood));
  if (remarks == remarks_) return;
  for (const std::string& remark : remarks) {
    if (std::ranges::find(remarks_, remark) == remarks_.end())
      host_.RaiseAlarm(intaglio_ALARM_WARNING, ErrorCodeName(ErrorCode::kFault), remark);
  }
  remarks_ = std::move(remarks);
  host_.SetHealth(intaglio_HEALTH_READY, {},
                  fmt::format("{}", fmt::join(remarks_, "; ")));
}

void JobService::TakeManualCommands() {
  manual_commands_.Take([this](const intaglio_ManualCommand& command) {
    const std::string cell(View(command.cell));
    if (IsCellName(cell)) permissions_.Open(cell, CellsInUse());
  });
}

CommandAnswer JobService::TakeCommand(const CommandView& command, Nanoseconds now) {
  if (command.kind == intaglio_COMMAND_MOUNT) return Mount(command, now);
  if (command.kind == intaglio_COMMAND_ADMIT) {
    const CommandAnswer answer = queue_.Admit(command.worker, command.operator_name, now);
    if (answer.taken())
      host::LogInfo("{} has admitted {} again", command.operator_name, command.worker);
    return answer;
  }
  return queue_.Receive(command, now);
}

CommandAnswer JobService::Mount(const CommandView& command, Nanoseconds now) {
  if (!command.mount_error.empty())
    return {intaglio_ANSWER_OUT_OF_RANGE, command.mount_error};
  if (!IsCellName(command.cell)) {
    return {intaglio_ANSWER_OUT_OF_RANGE,
            fmt::format("cell '{}' is no name of a machine", command.cell)};
  }
  const auto mount =
      queue_.mounts().RecordFor(command, host::UtcText(std::chrono::system_clock::now()));
  if (!mount) return {};
  store_.KeepMount(*mount);
  queue_.SetMount(*mount, command.basis, now);
  board_.Publish(*mount);
  host::LogInfo("{} has mounted in {}: {}", mount->operator_name, mount->cell,
                TextOf(mount->parts));
  return {};
}

void JobService::PieceChanged(const PieceRecord& piece) { store_.KeepPiece(piece); }

void JobService::BlockLoaded(const LoadedBlock& block) { store_.KeepLoadedBlock(block); }

void JobService::LeftOutChanged(const LeftOut& worker) { store_.KeepLeftOut(worker); }

void JobService::Close(Nanoseconds now) {
  queue_.Close(now);
  permissions_.Decide(queue_.Permissions(now));
}

void JobService::TakeTasks(Nanoseconds now) {
  const auto take = [&](const intaglio_TaskStatus& status) {
    TaskView view = ViewOf(status);
    if (view.stage > intaglio_STAGE_ENGRAVE || !queue_.MayKnow(view)) return;
    bool fresh = false;
    if (view.ended() && !queue_.AnswersAnOldRevocation(view)) {
      const auto bytes = View(status.outcome);
      const std::string outcome(bytes.begin(), bytes.end());
      view.checksum = ChecksumIn(outcome);
      fresh = store_.KeepTaskEnd(view, outcome);
    }
    const JobRecord* job = queue_.Find(view.task.job_uid);
    if (fresh && job != nullptr) view.warnings = WarningsAfter(view, *job);
    const bool had_ended = job != nullptr && job->ended();
    queue_.Receive(view, now);
    // What a job that was ended from outside has left in the glass comes afterwards,
    // maybe when the queue has forgotten the job.
    if (!view.ended() || view.stage != intaglio_STAGE_ENGRAVE) return;
    if (had_ended) {
      Settle(*job, false);
    } else if (job == nullptr && fresh) {
      const auto past = store_.LoadEnded(view.task.job_uid);
      if (past) statistics_.Ended(*past, false);
    }
  };
  reports_.TakeTasks(take, now);
}

std::optional<Warnings> JobService::WarningsAfter(const TaskView& view,
                                                  const JobRecord& job) {
  const bool made = view.state == intaglio_TASK_DONE &&
                    view.stage != intaglio_STAGE_ENGRAVE &&
                    view.task.attempt == job.attempt && !job.ended();
  if (!made) return std::nullopt;
  return WarningsOf(store_.OutcomesOf(job.uid, job.attempt), job.parts.size(),
                    FrozenOf(job).job());
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
    view.version = View(health.version);
    queue_.Receive(view, now);
  };
  reports_.TakeHealth(take, now);
}

// ---- What the queue decides ---------------------------------------------------------

void JobService::Changed(const JobRecord& job) {
  store_.Keep(job);
  if (job.ended()) {
    // Its machine may have fired since its last report.
    const bool may_fire = job.state != intaglio_JOB_DONE && job.arm.ever_granted() &&
                          !job.stage(intaglio_STAGE_ENGRAVE).worker.empty();
    return Settle(job, may_fire);
  }
  Publish(job);
  statistics_.Changed(job);
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
    board_.Publish(faulted);
  }
}

// The verdict is kept before the end is published with it.
void JobService::Settle(const JobRecord& job, bool more_is_expected) {
  statistics_.Ended(job, more_is_expected);
  if (store_.ResultOf(job.uid).verdict.empty()) {
    unsettled_.Add(job.uid, now_);
  } else {
    unsettled_.Remove(job.uid);
  }
  Publish(job);
}

void JobService::Publish(const JobRecord& job) {
  if (!job.ended() || job.uid.empty()) return board_.Publish(job);
  board_.PublishEnded(job, store_.ResultOf(job.uid));
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
  const JobSpec spec = FrozenOf(job).job();
  feed_.Start(order.task, MakesMarks(spec) ? MarkFilesOf(spec) : FilesOf(spec));
}

void JobService::StopFeed(const std::string& job_uid) { feed_.Stop(job_uid); }

void JobService::Forgotten(const JobRecord& job) {
  board_.Withdraw(job.uid, job.submission_uid);
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
  store_.KeepLeftOut({instance, "", false});
}

std::set<std::string> JobService::CellsInUse() const {
  std::set<std::string> cells;
  for (const auto& [uid, job] : queue_.jobs()) {
    if (!job.ended()) cells.insert(job.cell);
  }
  return cells;
}

}  // namespace intaglio::job_service
