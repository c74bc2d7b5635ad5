#include "services/marker/marker.h"

#include <fmt/format.h>

#include <utility>

#include "services/cell/pause_reason.h"
#include "services/cell/point_counts.h"
#include "services/platform/bus/error_code.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::marker {
namespace {

using bus::Borrow;
using bus::View;
// The loop turns every 5 ms and asks.
const auto kNoWakeOfMarker = [] {};
constexpr std::chrono::milliseconds kInterlockPeriod{100};

std::uint32_t BitsOf(const drivers::MarkDeviceState& state, bool stopped) {
  return (state.link_up ? 1u : 0u) | (state.key_on ? 2u : 0u) |
         (state.door_closed ? 4u : 0u) | (state.stop_released ? 8u : 0u) |
         (state.shutter_open ? 16u : 0u) | (state.safe_state ? 32u : 0u) |
         (stopped ? 64u : 0u);
}

}  // namespace

Marker::Marker(host::ServiceHost& host, const MachineSpec& machine,
               std::unique_ptr<drivers::MarkDriver> driver)
    : host_(host),
      machine_(machine),
      cell_(machine.name()),
      driver_(std::move(driver)),
      tasks_(host.bus(), bus::kEngraveTask),
      permission_(host.bus(), cell_),
      intake_(host.bus(), host.instance(), bus::kOrderedMarkBatch),
      task_publisher_(host.bus(), host.instance()),
      interlocks_(host.bus(), bus::kInterlock, cell_) {
  if (drivers::HandMotion* hand = driver_->hand())
    desk_.emplace(host.bus(), cell_, *hand, teacher_);
}

Marker::~Marker() = default;

void Marker::Turn(std::chrono::nanoseconds now) {
  now_ = now;
  if (journal_) journal_->ClearEvent();
  driver_->Poll();
  if (taken_over()) return;
  AlarmRefusal();
  permission_.Take(now);
  TakeTasks();
  if (!marking_) {
    (void)driver_->TakeEvents();
    WatchMachine();
  }
  TakeMarks();
  TakePrepared();
  TurnByHand();
  if (marking_) TurnMarking();
  PublishInterlock();
}

// A run does not begin before the driver is settled: motion by hand ends by the arm.
void Marker::TurnByHand() {
  if (!desk_) return;
  const bool runs = marking_ && marking_->phase() != Marking::Phase::kWaiting &&
                    marking_->phase() != Marking::Phase::kDone;
  desk_->Turn(runs, permission_.stop().pressed(), now_);
}

// Once for each device that is refused; a line that comes and goes raises no more.
void Marker::AlarmRefusal() {
  const drivers::MarkDeviceState& state = driver_->state();
  if (state.link_up) alarmed_refusal_.clear();
  if (state.refusal.empty() || state.refusal == alarmed_refusal_) return;
  alarmed_refusal_ = state.refusal;
  host_.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(ErrorCode::kRefused),
                   alarmed_refusal_, job_ ? job_->job_uid() : "");
}

void Marker::Stop() {
  leaves_ = true;
  if (marking_) {
    marking_->Stop("the marker was stopped");
  } else if (job_) {
    DropTask();
  }
}

void Marker::TakeTasks() {
  tasks_.Take([this](const intaglio_StageTask& task) {
    if (View(task.worker) != host_.instance()) return;
    const bool ours =
        job_ && View(task.job_uid) == job_->job_uid() && task.attempt == attempt_;
    if (task.revoked) {
      if (!ours) return;
      cancelled_ = true;
      if (marking_) {
        marking_->Stop("the job was cancelled");
      } else {
        EndTask(intaglio_TASK_FAILED, intaglio_ERROR_CANCELLED, "the job was cancelled");
      }
      return;
    }
    if (ours) return;
    if (marking_) {
      host::LogError("job {} is refused: {} is being made", View(task.job_uid),
                     job_->job_uid());
      return;
    }
    Begin(task);
  });
}

void Marker::Begin(const intaglio_StageTask& task) {
  FrozenJob job;
  const auto bytes = View(task.frozen_job);
  if (!job.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    host::LogError("the task of job {} cannot be parsed; it is ignored",
                   View(task.job_uid));
    return;
  }
  DropTask();
  job_ = std::move(job);
  attempt_ = task.attempt;
  cancelled_ = stall_alarmed_ = false;
  worked_ = {};
  takes_up_ = task.take_up;
  chain_.BeginJob();
  host_.SetHealth(intaglio_HEALTH_BUSY, job_->job_uid());
  if (auto checked = CheckMarkTask(*job_, machine_); !checked)
    return FailTask(checked.error());
  if (task.take_up) return Prepare(std::nullopt);
  if (auto opened = intake_.Open(job_->job_uid(), attempt_); !opened)
    return FailTask(opened.error());
  task_publisher_.Publish({.job_uid = job_->job_uid(), .attempt = attempt_}, now_);
}

// Also when none is wanted: what is not taken would wake the loop again and again.
void Marker::TakeMarks() {
  const auto taken = intake_.Poll();
  if (!job_ || marking_ || preparation_) return;
  if (!taken) return FailTask(taken.error());
  if (*taken) Prepare(intake_.TakeContent());
}

void Marker::Prepare(std::optional<mark::MarkSet> marks) {
  preparation_ = std::make_unique<Preparation>(
      [job = *job_, marks = std::move(marks)](const ProgressSink& progress) mutable {
        return PrepareMarking(job, std::move(marks), progress);
      },
      kNoWakeOfMarker);
}

void Marker::TakePrepared() {
  std::erase_if(abandoned_, [](const auto& one) { return one->ready(); });
  if (!preparation_ || !preparation_->ready()) return;
  auto prepared = preparation_->Take();
  preparation_.reset();
  if (!prepared) return FailTask(prepared.error());
  MarkingJob& job = prepared->job;
  if (job.earlier.damaged_records > 0) {
    host_.RaiseAlarm(intaglio_ALARM_WARNING, ErrorCodeName(ErrorCode::kUnreadable),
                     fmt::format("{} records of the journal in {} are damaged: check the "
                                 "piece before you resume",
                                 job.earlier.damaged_records, job_->result_directory()),
                     job.uid);
  }
  // What an earlier process left is compared with the machine as it is now.
  if (takes_up_) {
    chain_.TakeUp({std::max(1u, job.earlier.power_up), job.earlier.openings});
  }
  logged_message_.clear();
  journal_ = std::move(prepared->journal);
  marking_ = std::make_unique<Marking>(std::move(job), *driver_, *journal_, chain_);
  turned_at_ = now_;
}

cell::GrantInputs Marker::Inputs() const {
  return permission_.InputsFor(job_ ? job_->job_uid() : "", job_ ? job_->epoch() : 0,
                               now_);
}

// While no marks are there: an arm may have been given already.
void Marker::WatchMachine() {
  const cell::GrantInputs inputs = Inputs();
  const cell::ChainLinks links = LinksOf(driver_->state(), inputs);
  if (!job_) return chain_.Watch(links, now_);
  (void)chain_.Turn(links, now_);
  const std::string& refusal = driver_->state().refusal;
  if (!refusal.empty()) chain_.Latch(false);
  if (inputs.grant.number == 0 || !chain_.has_lost(inputs.grant)) return;
  task_publisher_.Publish(
      {.job_uid = job_->job_uid(),
       .attempt = attempt_,
       .state = intaglio_TASK_PAUSED,
       .pause_reason = refusal.empty() ? cell::PauseReasonOf(chain_.spent_by())
                                       : intaglio_PAUSE_FAULT,
       .message =
           refusal.empty() ? TextOf(chain_.spent_by()) : refusal + ", then resume"},
      now_);
}

void Marker::TurnMarking() {
  if (marking_->phase() == Marking::Phase::kRunning) worked_ += now_ - turned_at_;
  turned_at_ = now_;
  marking_->Turn(Inputs());
  const cell::PointLedger& ledger = marking_->ledger();
  if (marking_->phase() == Marking::Phase::kDone) {
    if (leaves_ && (!ledger.all_ended() || marking_->asks())) return DropTask();
    return EndTask(cancelled_ ? intaglio_TASK_FAILED : intaglio_TASK_DONE,
                   cancelled_ ? intaglio_ERROR_CANCELLED : intaglio_ERROR_NONE,
                   cancelled_ ? marking_->message() : "");
  }
  const bool waits = marking_->waits();
  cell::TaskReport report{.job_uid = job_->job_uid(), .attempt = attempt_};
  report.state = waits ? intaglio_TASK_PAUSED : intaglio_TASK_RUNNING;
  report.counts = cell::CountsOf(ledger);
  report.done_count = report.counts.made;
  report.total_count = ledger.size();
  report.elapsed_s = std::chrono::duration<double>(worked_).count();
  if (waits) {
    report.pause_reason =
        PauseReasonOf(cell::PausedEngraving{.faulted = marking_->faulted(),
                                            .lost_a_line = marking_->lost_a_line(),
                                            .asks = marking_->asks(),
                                            .spent_by = chain_.spent_by()});
  }
  report.alarm = marking_->alarm().empty() ? "" : "the marks make no progress";
  if (!marking_->alarm().empty() && !stall_alarmed_) {
    host_.RaiseAlarm(intaglio_ALARM_WARNING, "no_progress", marking_->alarm(),
                     job_->job_uid());
  }
  stall_alarmed_ = !marking_->alarm().empty();
  report.message = marking_->message();
  if (report.message != logged_message_) {
    logged_message_ = report.message;
    if (!logged_message_.empty()) host::LogInfo("{}", logged_message_);
  }
  task_publisher_.Publish(report, now_);
}

EngraveOutcome Marker::Outcome() const {
  EngraveOutcome outcome;
  const intaglio_PointCounts counts = cell::CountsOf(marking_->ledger());
  outcome.set_planned_count(counts.planned);
  outcome.set_made_count(counts.made);
  outcome.set_missed_count(counts.missed);
  outcome.set_skipped_count(counts.skipped);
  outcome.set_uncertain_count(counts.uncertain);
  outcome.set_run_count(marking_->run_count());
  outcome.set_settled_by_memory_count(marking_->settled_by_memory_count());
  return outcome;
}

void Marker::FailTask(const Error& error) {
  EndTask(intaglio_TASK_FAILED, bus::WireOf(error.code), error.message);
}

void Marker::EndTask(intaglio_TaskState state, intaglio_ErrorCode code,
                     const std::string& message) {
  cell::TaskReport report{
      .job_uid = job_->job_uid(), .attempt = attempt_, .state = state};
  report.elapsed_s = std::chrono::duration<double>(worked_).count();
  report.error_code = code;
  report.message = message;
  StageOutcome outcome;
  outcome.set_elapsed_s(report.elapsed_s);
  if (marking_) {
    *outcome.mutable_engrave() = Outcome();
    report.counts = cell::CountsOf(marking_->ledger());
    report.total_count = report.counts.planned;
    report.done_count = report.counts.made;
  }
  report.outcome = outcome.SerializeAsString();
  DropTask();
  task_publisher_.Publish(report, now_);
  host_.SetHealth(intaglio_HEALTH_READY);
}

// The journal's last records are on disk before the end of the job is published.
void Marker::DropTask() {
  marking_.reset();
  journal_.reset();
  intake_.Close();
  if (preparation_) {
    preparation_->Cancel();
    abandoned_.push_back(std::move(preparation_));
  }
  job_.reset();
}

void Marker::PublishInterlock() {
  const drivers::MarkDeviceState& state = driver_->state();
  const host::StopLatch& stop = permission_.stop();
  const std::uint32_t bits = BitsOf(state, stop.pressed());
  if (bits == published_interlocks_ && stop.revision() == stop_revision_ &&
      now_ < next_interlock_) {
    return;
  }
  published_interlocks_ = bits;
  stop_revision_ = stop.revision();
  next_interlock_ = now_ + kInterlockPeriod;
  intaglio_Interlock sample{};
  sample.cell = Borrow(cell_);
  sample.bus_stop_pressed = stop.pressed();
  const auto held = host::WireOf(stop.held());
  Borrow(sample.bus_stops, held);
  sample.laser_link_up = state.link_up;
  const std::string& message = state.refusal.empty() ? state.message : state.refusal;
  sample.message = Borrow(message);
  if (state.link_up) {
    sample.key_on = state.key_on;
    sample.door_closed = state.door_closed;
    sample.emergency_stop_released = state.stop_released;
    sample.safe_state = state.safe_state;
    sample.shutters_open = state.shutter_open ? 1 : 0;
  }
  (void)interlocks_.Write(sample);
}

}  // namespace intaglio::marker
