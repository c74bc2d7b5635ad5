#include "services/synchronizer/synchronizer.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/cell/begun_job.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/accessories.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/zero_change.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/host/process/log.h"
#include "services/synchronizer/job_folder.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "services/synchronizer/task_check.h"

namespace intaglio::synchronizer {
namespace {

// A state of the stage is younger than this, or its bridge does not work.
constexpr std::chrono::seconds kStateTime{2};

bool AnswersNow(const MotionView& motion) {
  return motion.answers && motion.fresh && !motion.line_down();
}

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
      motion_(host.bus(), cell_),
      by_hand_(host.bus(), bus::kManualState, cell_),
      credit_(host.bus(), bus::RolePartition(bus::CellRole(cell_))),
      segments_(host.bus(), bus::kMotionSegmentBatch, cell_),
      intake_(host.bus(), host.instance(), bus::kPathBatch),
      publisher_(host.bus(), cell_, host.instance()),
      laser_driver_(std::move(laser)),
      laser_(*laser_driver_),
      light_(laser_, LowestRate(machine_)),
      lamp_hold_(laser_, machine_.laser().lamp_hold_s(), LowestRate(machine_)),
      laser_stop_(laser_),
      outputs_(laser_, OutputsUnderArm(machine_, false), OutputsUnderArm(machine_, true)),
      feed_([this](const intaglio_MotionSegmentBatch& b) { return segments_.Write(b); },
            [this](const std::string& stream) { return credit_.Find(stream); }),
      drive_(host.bus(), cell_, host.instance()),
      task_(host, cell_, *this) {}

Synchronizer::~Synchronizer() = default;

void Synchronizer::Turn(std::chrono::nanoseconds now) {
  now_ = now;
  if (journal_) journal_->ClearEvent();
  const auto take = [this](const auto& report) {
    if (engraving_) engraving_->Receive(report);
  };
  laser_.Poll(take, take);
  if (laser_.taken_over()) return;
  credit_.Poll();
  task_.Receive(now);
  motion_.Receive(task_.permission(), laser_, now);
  laser_stop_.Turn(task_.permission().stop().pressed(), IsIdle(), now);
  task_.ReceiveTasks();
  CheckZeros();
  TurnDrive();
  TurnLight();
  if (task_.has_job() && !engraving_) {
    ReceivePath();
    AcceptPrepared();
  } else {
    (void)intake_.Poll();  // what is left would wake the loop again and again
  }
  task_.Turn();
  TurnOutputs();
  publisher_.PublishLaser(laser_, task_.permission().stop(), now);
  publisher_.Flush(now, false);
}

bool Synchronizer::IsIdle() const {
  const bool works = engraving_ && engraving_->activity() != WorkStates::Activity::kIdle;
  return !works && !light_.holds();
}

void Synchronizer::Stop() {
  drive_.Stop();
  task_.Stop("the synchronizer was stopped");
}

std::string Synchronizer::WhyNoArmCounts() const {
  const std::string other_device = OtherDevice(motion_.view(), laser_);
  return other_device.empty() ? zero_refusal_ : other_device;
}

ChainLinks Synchronizer::Links(const GrantInputs& inputs) const {
  return LinksOf(inputs, motion_.view(), laser_, 0);
}

Status Synchronizer::Begin(FrozenJob& job, const intaglio_StageTask& task) {
  plan_ = {};
  planned_ = false;
  INTAGLIO_TRY(ReadTaught());
  INTAGLIO_TRY(CheckTask(job, machine_, machine_file_));
  *job.mutable_machine() = machine_;
  approach_ = ApproachState::kDue;
  zeros_checked_ = block_driven_by_ = {};
  block_failure_.clear();
  zero_refusal_.clear();
  if (task.take_up) {
    // The zeros it was begun with; CheckZeros compares them with those of now.
    const auto begun = INTAGLIO_TRY(ReadBegunJob(job.result_directory()));
    if (begun) *job.mutable_machine()->mutable_taught() = begun->machine().taught();
    Prepare(std::nullopt);
    return {};
  }
  return intake_.Open(job.job_uid(), task.attempt);
}

// What was taught since this process read its profile counts from the next job on.
Status Synchronizer::ReadTaught() {
  const auto machine = INTAGLIO_TRY(ReadMachineFile(machine_file_));
  machine_.clear_taught();
  if (machine.has_taught()) *machine_.mutable_taught() = machine.taught();
  return {};
}

void Synchronizer::ReceivePath() {
  const auto whole = intake_.Poll();
  if (!whole) return task_.Fail(whole.error());
  if (*whole) Prepare(intake_.TakeContent());
}

void Synchronizer::Prepare(std::optional<PointCloud> path) {
  planner_.Begin({task_.job(), std::move(path), MountMisfit(task_.job(), mounted_)});
}

void Synchronizer::AcceptPrepared() {
  auto prepared = planner_.TakePrepared();
  if (!prepared) return;
  if (!*prepared) return task_.Fail(prepared->error());
  StartEngraving(std::move(**prepared));
}

void Synchronizer::StartEngraving(PreparedJob prepared) {
  EngravingJob& job = prepared.engraving;
  task_.BeginWork(job.earlier, {job.earlier.power_up, job.earlier.openings},
                  task_.job().result_directory() + "/" + kJournalFile);
  job.lamp_stays = lamp_hold_.holds_lamps();
  publisher_.BeginJob(job.uid);
  journal_ = std::move(prepared.journal);
  engraving_ = std::make_unique<Engraving>(
      std::move(job), laser_, feed_, *journal_, task_.chain(),
      [this](const PulseResult& result) { publisher_.Add(result); });
}

void Synchronizer::AcceptPlan() {
  if (planned_) return;
  const Result<PlanSummary>* plan = planner_.summary();
  if (plan == nullptr) return;
  planned_ = true;
  if (*plan) {
    plan_ = **plan;
    engraving_->SetPlan(std::move(plan_.point_ticks));
  } else {
    host::LogError("the plan of job {} cannot be computed: {}", task_.job().job_uid(),
                   plan->error().message);
  }
}

void Synchronizer::TurnWork(const GrantInputs& inputs) {
  EngravingInputs with_motion = motion_.InputsWith(inputs);
  with_motion.zero_refusal = zero_refusal_;
  with_motion.stage_approaches = approach_ != ApproachState::kOver;
  with_motion.block_failure = std::exchange(block_failure_, {});
  engraving_->Turn(with_motion);
  AcceptPlan();
}

std::string Synchronizer::PendingAtEnd() const {
  return planned_ ? ""
                  : "all points are engraved; the figures of the plan are being computed";
}

void Synchronizer::NoteDone() {
  publisher_.Flush(now_, true);
  lamp_hold_.Begin(now_);
}

void Synchronizer::AddTo(EngraveOutcome& outcome) const {
  outcome.set_estimate_ticks(plan_.ticks);
  outcome.set_first_tick(engraving_->fired_ticks().first());
  outcome.set_last_tick(engraving_->fired_ticks().last());
  outcome.set_used_ticks(engraving_->fired_ticks().count());
  outcome.set_controller_pulse_count(laser_.status().pulse_count);
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
}

void Synchronizer::NoteEnd(const std::string& job_uid, bool done) {
  const bool had_grant = approach_ == ApproachState::kOver;
  if (approach_ == ApproachState::kDrives || approach_ == ApproachState::kBlock)
    drive_.Stop();
  approach_ = ApproachState::kNone;
  if (done && had_grant && machine_.taught().has_park())
    DriveTo("taught park position", machine_.taught().park(), job_uid);
}

void Synchronizer::DriveTo(const char* name, const Vector3& axes,
                           const std::string& job_uid) {
  drive_.Start({.name = name, .axes = Vec3(axes.x(), axes.y(), axes.z())}, job_uid, now_);
}

// A zero may be taught while a job waits, and a profile be edited: each grant is compared
// before anything is made by it. What is not begun is prepared anew; what is begun has to
// be made with the zero that it has.
void Synchronizer::CheckZeros() {
  if (!engraving_ || engraving_->activity() != WorkStates::Activity::kIdle) return;
  const GrantInputs inputs = task_.Inputs();
  if (!inputs.permission_fresh || !inputs.permission_granted) return;
  if (inputs.grant <= zeros_checked_) return;
  zeros_checked_ = inputs.grant;
  zero_refusal_.clear();
  if (const auto read = ReadTaught(); !read) {
    zero_refusal_ = read.error().message;
    return;
  }
  const FrozenJob& job = task_.job();
  const std::string change = ZeroChange(job.job(), job.machine(), machine_);
  if (change.empty()) return;
  if (!engraving_->started()) return PrepareAnew();
  zero_refusal_ = change +
                  ": cancel the job, or bring the zero back (intaglio teach undo), for "
                  "what is made already would not fit to the rest";
}

void Synchronizer::PrepareAnew() {
  const FrozenJob& job = task_.job();
  if (auto checked = CheckTask(job, machine_, machine_file_); !checked)
    return task_.Fail(checked.error());
  host::LogInfo("job {} is prepared anew: {}", job.job_uid(),
                ZeroChange(job.job(), job.machine(), machine_));
  task_.SetMachine(machine_);
  if (engraving_->has_lamp()) lamp_hold_.End(now_);
  if (approach_ == ApproachState::kDrives || approach_ == ApproachState::kBlock)
    drive_.Stop();
  approach_ = ApproachState::kDue;
  block_driven_by_ = {};
  engraving_.reset();
  journal_.reset();
  plan_ = {};
  planned_ = false;
  planner_.Begin({job, std::nullopt, MountMisfit(job, mounted_), true});
}

// Submitting a job moves nothing: the drive to its beginning waits for its grant, ends
// with it, and begins anew with the next one.
void Synchronizer::Approach() {
  if (!engraving_ || engraving_->activity() != WorkStates::Activity::kIdle) return;
  const bool granted = task_.has_grant();
  if (approach_ == ApproachState::kDue && granted) {
    drive_.Stop();  // what parks after the job before
    if (machine_.taught().has_sample())
      DriveTo("taught sample position", machine_.taught().sample(),
              task_.job().job_uid());
    approach_ = ApproachState::kDrives;
  } else if (approach_ == ApproachState::kOver && granted && BlockIsAway()) {
    BringBlock();
  } else if (!granted && drive_.drives() &&
             (approach_ == ApproachState::kDrives ||
              approach_ == ApproachState::kBlock)) {
    drive_.Stop();
    approach_ = ApproachState::kDue;
    block_driven_by_ = {};
  }
}

// Where the controller has it, not where it was driven.
bool Synchronizer::BlockIsAway() const {
  const auto place_mm = BlockStageOf(task_.job());
  return place_mm && AnswersNow(motion_.view()) &&
         !motion_.view().HasBlockAt(*place_mm, machine_.position_tolerance_um() / 1e3);
}

// A block that lies at its place already counts as brought there by this arm: who moves
// it afterwards costs the arm.
void Synchronizer::EndApproach() {
  approach_ = ApproachState::kOver;
  if (!BlockStageOf(task_.job()) || !AnswersNow(motion_.view()) || BlockIsAway()) return;
  block_driven_by_ = task_.Inputs().grant;
  block_driven_at_ = now_;
}

// Once by each arm of a person. A drive that has ended well, and the block elsewhere: it
// was pushed, or the newest state of the stage is still to come.
void Synchronizer::BringBlock() {
  if (task_.Inputs().grant.number <= block_driven_by_.number) {
    if (now_ - block_driven_at_ > kStateTime)
      FailBlock("the controller reports it elsewhere");
    return;
  }
  const BlockStage& stage = machine_.head_over_block().block_stage();
  const Vec2 place_mm = *BlockStageOf(task_.job());
  const double speed_mm_s = std::min(
      {CellDrive::kSpeedMmS, stage.x().max_speed_mm_s(), stage.y().max_speed_mm_s()});
  const std::chrono::duration<double> way_s((place_mm - motion_.view().block_mm).norm() /
                                            speed_mm_s);
  drive_.Start({"job's place of the block", intaglio_MANUAL_BLOCK,
                Vec3(place_mm.x(), place_mm.y(), 0), speed_mm_s,
                CellDrive::kPatience +
                    std::chrono::duration_cast<std::chrono::nanoseconds>(2 * way_s)},
               task_.job().job_uid(), now_);
  block_driven_by_ = task_.Inputs().grant;
  approach_ = ApproachState::kBlock;
}

// What the motion line or the bridge lost in mid-move does not go on by itself.
void Synchronizer::EndBlockDrive() {
  if (drive_.drives() && AnswersNow(motion_.view())) return;
  const std::string why = drive_.drives()
                              ? "the motion bridge or its line was lost meanwhile"
                              : drive_.message();
  drive_.Stop();
  approach_ = ApproachState::kOver;
  block_driven_at_ = now_;
  if (!why.empty()) FailBlock(why);
}

void Synchronizer::FailBlock(const std::string& why) {
  block_failure_ = fmt::format(
      "the block did not come to the job's place: {}; check the stage that carries it, "
      "then resume",
      why);
}

// The stage is at rest then, or brakes: the bridge has ended the motion, or is ending it.
void Synchronizer::TurnDrive() {
  Approach();
  const bool drove = drive_.drives();
  drive_.Turn(now_);
  if (approach_ == ApproachState::kBlock) EndBlockDrive();
  if (approach_ == ApproachState::kDrives && !drive_.drives()) EndApproach();
  if (!drove || drive_.drives() || drive_.message().empty()) return;
  host_.RaiseAlarm(intaglio_ALARM_WARNING, "position_not_reached",
                   fmt::format("the {} was not reached, and the stage was stopped: {}",
                               drive_.name(), drive_.message()),
                   drive_.job_uid());
}

void Synchronizer::TurnLight() {
  by_hand_.TakeAll(
      [this](const intaglio_ManualState& state, const bus::SampleOrigin& origin) {
        light_.Receive(state, origin.alive, now_);
      });
  if (engraving_ && engraving_->has_lamp()) {
    lamp_hold_.Yield();
    return light_.Yield();
  }
  const bool stopped = task_.leaves() || task_.permission().stopped();
  lamp_hold_.Turn(stopped, now_);
  light_.Turn(!task_.has_job() && !stopped, now_);
}

void Synchronizer::TurnOutputs() {
  const bool armed = engraving_ && engraving_->has_lamp() && task_.has_grant() &&
                     !task_.leaves() &&
                     engraving_->activity() != WorkStates::Activity::kDone;
  outputs_.Turn(armed, armed && engraving_->activity() == WorkStates::Activity::kRuns,
                now_);
}

void Synchronizer::Drop() {
  engraving_.reset();
  journal_.reset();
  intake_.Close();
  planner_.Abandon();
}

}  // namespace intaglio::synchronizer
