#include "services/synchronizer/synchronizer.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "services/cell/pause_reason.h"
#include "services/cell/point_counts.h"
#include "services/job/job_file.h"
#include "services/platform/bus/error_code.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/synchronizer/cell_names.h"
#include "services/synchronizer/job_folder.h"
#include "services/synchronizer/task_check.h"

namespace intaglio::synchronizer {
namespace {

using bus::View;

double LowestRate(const MachineSpec& machine) {
  const auto& rates_hz = machine.laser().rates_hz();
  return rates_hz.empty() ? 1 : *std::min_element(rates_hz.begin(), rates_hz.end());
}

}  // namespace

Synchronizer::Synchronizer(host::ServiceHost& host, const MachineSpec& machine,
                           std::string machine_file, const MountedParts& mounted,
                           std::unique_ptr<drivers::LaserController> laser)
    : host_(host),
      machine_(machine),
      machine_file_(std::move(machine_file)),
      mounted_(mounted),
      cell_(machine.name()),
      tasks_(host.bus(), bus::kEngraveTask),
      permissions_(host.bus(), bus::kPermission, cell_),
      stops_(host.bus(), bus::kEmergencyStop, cell_),
      motion_(host.bus(), bus::kMotionState, cell_),
      positions_(host.bus(), bus::kPositionReport, cell_),
      by_hand_(host.bus(), bus::kManualState, cell_),
      credit_(host.bus(), bus::RolePartition(bus::CellRole(cell_))),
      segments_(host.bus(), bus::kMotionSegmentBatch, cell_),
      intake_(host.bus(), host.instance(), bus::kPathBatch),
      publisher_(host.bus(), cell_, host.instance()),
      laser_driver_(std::move(laser)),
      laser_(*laser_driver_),
      light_(laser_, LowestRate(machine_)),
      lamp_hold_(laser_, machine_.laser().lamp_hold_s(), LowestRate(machine_)),
      feed_([this](const intaglio_MotionSegmentBatch& b) { return segments_.Write(b); },
            [this](const std::string& stream) { return credit_.Find(stream); }),
      drive_(host.bus(), cell_, host.instance()) {}

Synchronizer::~Synchronizer() = default;

void Synchronizer::Turn(std::chrono::nanoseconds now) {
  now_ = now;
  stop_came_ = false;
  if (journal_) journal_->ClearEvent();
  const auto take = [this](const auto& report) {
    if (engraving_) engraving_->Take(report);
  };
  laser_.Poll(take, take);
  if (laser_.taken_over()) return;
  AlarmRefusal();
  credit_.Poll();
  TakePermission(now);
  TakeMotion(now);
  TakePositions();
  TakeTasks();
  TurnDrive();
  TurnLight();
  if (!engraving_) WatchMachine(now);
  if (job_ && !engraving_) {
    TakePath();
    if (!drive_.drives()) TakePrepared();
  } else {
    (void)intake_.Poll();  // what is left would wake the loop again and again
  }
  if (engraving_) Engrave(now);
  publisher_.PublishLaser(laser_, stop_, now);
  publisher_.Flush(now, false);
}

// Once for each device that is refused; a line that comes and goes raises no more.
void Synchronizer::AlarmRefusal() {
  if (laser_.up()) alarmed_refusal_.clear();
  if (laser_.refusal().empty() || laser_.refusal() == alarmed_refusal_) return;
  alarmed_refusal_ = laser_.refusal();
  host_.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(ErrorCode::kRefused),
                   alarmed_refusal_, job_ ? job_->job_uid() : "");
}

void Synchronizer::Stop() {
  leaves_ = true;
  drive_.Stop();
  if (engraving_) {
    engraving_->Stop("the synchronizer was stopped");
  } else if (job_) {
    DropTask();
  }
}

void Synchronizer::TakeTasks() {
  tasks_.Take([this](const intaglio_StageTask& task) {
    if (View(task.worker) != host_.instance()) return;
    const bool ours = job_ && View(task.job_uid) == job_->job_uid();
    if (task.revoked) {
      if (!ours || task.attempt != attempt_) return;
      cancelled_ = true;
      if (engraving_) {
        engraving_->Stop("the job was cancelled", task.take_up);
      } else {
        EndTask(intaglio_TASK_FAILED, intaglio_ERROR_CANCELLED, "the job was cancelled");
      }
      return;
    }
    if (ours && task.attempt == attempt_) return;
    if (engraving_) {
      host::LogError("job {} is refused: {} is being engraved", View(task.job_uid),
                     job_->job_uid());
      return;
    }
    Begin(task);
  });
}

void Synchronizer::Begin(const intaglio_StageTask& task) {
  FrozenJob job;
  const auto bytes = View(task.frozen_job);
  if (!job.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    host::LogError("the task of job {} cannot be parsed; it is ignored",
                   View(task.job_uid));
    return;
  }
  job_ = std::move(job);
  attempt_ = task.attempt;
  cancelled_ = false;
  worked_ = {};
  plan_ = {};
  planned_ = false;
  planner_.Abandon();
  chain_.BeginJob();
  taken_up_ = task.take_up;
  host_.SetHealth(intaglio_HEALTH_BUSY, job_->job_uid());
  if (auto taught = TakeTaught(); !taught) return FailTask(taught.error());
  if (auto checked = CheckTask(*job_, machine_, machine_file_); !checked) {
    return FailTask(checked.error());
  }
  *job_->mutable_machine() = machine_;
  Drive("sample", machine_.taught().has_sample(), machine_.taught().sample(),
        job_->job_uid());
  if (task.take_up) return Prepare(std::nullopt);
  if (auto opened = intake_.Open(job_->job_uid(), attempt_); !opened) {
    return FailTask(opened.error());
  }
  publisher_.PublishTask({.job_uid = job_->job_uid(), .attempt = attempt_}, now_);
}

// What was taught since this process read its profile counts from the next job on.
Status Synchronizer::TakeTaught() {
  const auto machine = ReadMachineFile(machine_file_);
  if (!machine) return tl::unexpected(machine.error());
  machine_.clear_taught();
  if (machine->has_taught()) *machine_.mutable_taught() = machine->taught();
  return {};
}

void Synchronizer::FailTask(const Error& error) {
  EndTask(intaglio_TASK_FAILED, bus::WireOf(error.code), error.message);
}

void Synchronizer::TakePath() {
  const auto whole = intake_.Poll();
  if (!whole) return FailTask(whole.error());
  if (*whole) Prepare(intake_.TakeContent());
}

void Synchronizer::Prepare(std::optional<PointCloud> path) {
  planner_.Begin({*job_, std::move(path), MountMisfit(*job_, mounted_)});
}

void Synchronizer::TakePrepared() {
  auto prepared = planner_.TakePrepared();
  if (!prepared) return;
  if (!*prepared) return FailTask(prepared->error());
  StartEngraving(std::move(**prepared));
}

void Synchronizer::StartEngraving(PreparedJob prepared) {
  EngravingJob& job = prepared.engraving;
  if (job.earlier.damaged_records > 0) {
    const std::filesystem::path folder = job_->result_directory();
    host_.RaiseAlarm(
        intaglio_ALARM_WARNING, ErrorCodeName(ErrorCode::kUnreadable),
        fmt::format("{} records of {} are damaged: check the block before "
                    "you resume",
                    job.earlier.damaged_records, (folder / kJournalFile).string()),
        job.uid);
  }
  // What an earlier process left is compared with the machine as it is now.
  if (taken_up_) chain_.TakeUp({job.earlier.power_up, job.earlier.openings});
  job.lamp_stays = lamp_hold_.holds_lamps();
  publisher_.BeginJob(job.uid);
  logged_message_.clear();
  progress_alarmed_ = false;
  journal_ = std::move(prepared.journal);
  engraving_ = std::make_unique<Engraving>(
      std::move(job), laser_, feed_, *journal_, chain_,
      [this](const PulseResult& result) { publisher_.Add(result); });
}

void Synchronizer::TakePlan() {
  if (planned_) return;
  const Result<PlanSummary>* plan = planner_.summary();
  if (plan == nullptr) return;
  planned_ = true;
  if (*plan) {
    plan_ = **plan;
    engraving_->SetPlan(std::move(plan_.point_ticks));
  } else {
    host::LogError("the plan of job {} cannot be computed: {}", job_->job_uid(),
                   plan->error().message);
  }
}

void Synchronizer::Engrave(std::chrono::nanoseconds now) {
  const bool ran = engraving_->phase() == Engraving::Phase::kRunning;
  if (ran) worked_ += now - turned_at_;
  turned_at_ = now;
  engraving_->Turn(InputsAt(now));
  TakePlan();
  const PointLedger& ledger = engraving_->ledger();
  if (engraving_->phase() == Engraving::Phase::kDone) {
    publisher_.Flush(now, true);
    lamp_hold_.Begin(now);
    if (leaves_ && (!ledger.all_ended() || engraving_->asks())) return DropTask();
    if (cancelled_) {
      return EndTask(intaglio_TASK_FAILED, intaglio_ERROR_CANCELLED,
                     engraving_->message());
    }
    if (planned_) return EndTask(intaglio_TASK_DONE, intaglio_ERROR_NONE, "");
  }
  const bool done = engraving_->phase() == Engraving::Phase::kDone;
  const bool waits = !done && engraving_->waits();
  TaskReport report{.job_uid = job_->job_uid(), .attempt = attempt_};
  report.state = waits ? intaglio_TASK_PAUSED : intaglio_TASK_RUNNING;
  report.done_count = ledger.count(PointState::kMade) + ledger.count(PointState::kMissed);
  report.total_count = ledger.size();
  report.elapsed_s = std::chrono::duration<double>(worked_).count();
  report.estimate_ticks = plan_.ticks;
  if (waits) {
    report.pause_reason = PauseReasonOf({.faulted = engraving_->faulted(),
                                         .lost_a_line = engraving_->lost_a_line(),
                                         .asks = engraving_->asks(),
                                         .spent_by = chain_.spent_by()});
  }
  report.counts = CountsOf(ledger);
  report.alarm = done ? "" : engraving_->alarm();
  RaiseNoProgress(report.alarm);
  report.message =
      done ? "all points are engraved; the figures of the plan are being computed"
           : engraving_->message();
  if (report.message != logged_message_) {
    logged_message_ = report.message;
    if (!logged_message_.empty()) host::LogInfo("{}", logged_message_);
  }
  publisher_.PublishTask(report, now);
}

// Once, when the progress stops; the task has the newest figures.
void Synchronizer::RaiseNoProgress(const std::string& alarm) {
  if (!alarm.empty() && !progress_alarmed_) {
    host_.RaiseAlarm(intaglio_ALARM_WARNING, "no_progress", alarm, job_->job_uid());
  }
  progress_alarmed_ = !alarm.empty();
}

EngraveOutcome Synchronizer::Outcome() const {
  EngraveOutcome outcome;
  const intaglio_PointCounts counts = CountsOf(engraving_->ledger());
  outcome.set_planned_count(counts.planned);
  outcome.set_made_count(counts.made);
  outcome.set_missed_count(counts.missed);
  outcome.set_skipped_count(counts.skipped);
  outcome.set_uncertain_count(counts.uncertain);
  outcome.set_estimate_ticks(plan_.ticks);
  outcome.set_first_tick(engraving_->first_fired_tick());
  outcome.set_last_tick(engraving_->last_fired_tick());
  if (engraving_->first_fired_tick() != 0) {
    outcome.set_used_ticks(engraving_->last_fired_tick() -
                           engraving_->first_fired_tick() + 1);
  }
  outcome.set_controller_pulse_count(laser_.status().pulse_count);
  outcome.set_run_count(engraving_->run_count());
  outcome.set_settled_by_memory_count(engraving_->settled_by_memory_count());
  outcome.set_plan_checksum(plan_.checksum);
  outcome.set_planned_max_move_um(1e3 * plan_.moves.max_mm);
  outcome.set_planned_rms_move_um(1e3 * plan_.moves.rms_mm());
  if (plan_.predicted) {
    outcome.set_predicted_rms_error_um(plan_.predicted->rms_um);
    outcome.set_predicted_max_error_um(plan_.predicted->max_um);
    outcome.set_wrong_mechanics_max_error_um(plan_.predicted->wrong_mechanics_max_um);
  }
  outcome.set_min_speed_percent(engraving_->min_speed_percent());
  outcome.set_max_speed_percent(engraving_->max_speed_percent());
  outcome.set_speed_changes(engraving_->speed_changes());
  return outcome;
}

void Synchronizer::EndTask(intaglio_TaskState state, intaglio_ErrorCode code,
                           const std::string& message) {
  TaskReport report{.job_uid = job_->job_uid(), .attempt = attempt_, .state = state};
  report.elapsed_s = std::chrono::duration<double>(worked_).count();
  report.estimate_ticks = plan_.ticks;
  report.error_code = code;
  report.message = message;
  StageOutcome outcome;
  outcome.set_elapsed_s(report.elapsed_s);
  if (engraving_) {
    *outcome.mutable_engrave() = Outcome();
    report.total_count = engraving_->ledger().size();
    report.done_count = outcome.engrave().made_count() + outcome.engrave().missed_count();
    report.counts = CountsOf(engraving_->ledger());
  }
  report.outcome = outcome.SerializeAsString();
  DropTask();
  Drive("park", state == intaglio_TASK_DONE && machine_.taught().has_park(),
        machine_.taught().park(), report.job_uid);
  publisher_.PublishTask(report, now_);
  host_.SetHealth(intaglio_HEALTH_READY);
}

void Synchronizer::Drive(const char* name, bool taught, const Vector3& axes,
                         const std::string& job_uid) {
  drive_.Stop();
  if (!taught) return;
  drive_name_ = name;
  drive_job_ = job_uid;
  drive_.Start(Vec3(axes.x(), axes.y(), axes.z()), now_);
}

// The stage is at rest then, or brakes: the bridge has ended the motion, or is ending it.
void Synchronizer::TurnDrive() {
  const bool drove = drive_.drives();
  drive_.Turn(now_);
  if (!drove || drive_.drives() || drive_.message().empty()) return;
  host_.RaiseAlarm(intaglio_ALARM_WARNING, "position_not_reached",
                   fmt::format("the taught {} position was not reached, and the stage "
                               "was stopped: {}",
                               drive_name_, drive_.message()),
                   drive_job_);
}

void Synchronizer::TurnLight() {
  by_hand_.TakeAll(
      [this](const intaglio_ManualState& state, const bus::SampleOrigin& origin) {
        light_.Take(state, origin.alive, now_);
      });
  if (engraving_) {
    lamp_hold_.Yield();
    return light_.Yield();
  }
  lamp_hold_.Turn(leaves_ || stop_.pressed() || stop_came_, now_);
  light_.Turn(!job_ && !leaves_ && !stop_.pressed() && !stop_came_, now_);
}

// The journal's last records are on disk before the end of the job is published.
void Synchronizer::DropTask() {
  engraving_.reset();
  journal_.reset();
  intake_.Close();
  planner_.Abandon();
  job_.reset();
}

}  // namespace intaglio::synchronizer
