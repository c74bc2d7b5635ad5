#include "services/job_service/queue/arming.h"

#include <gmock/gmock.h>

#include "proto/task.pb.h"
#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

class ArmingTest : public testing::Test {
 protected:
  ArmingTest() {
    JobRecord job;
    job.number = 1;
    job.uid = "j1";
    job.epoch = 7;
    job.cell = "c";
    job.attempt = 1;
    job.state = intaglio_JOB_WAITING_FOR_ARM;
    job.stage(intaglio_STAGE_ENGRAVE).worker = "y";
    job_ = &book_.Add(job);
    workers_.Assign("y", job_->TaskOf(intaglio_STAGE_ENGRAVE), now_);
  }
  CommandView Of(intaglio_JobCommandKind kind) {
    CommandView command;
    command.epoch = 7;
    command.kind = kind;
    command.operator_name = "ann@shop";
    command.disarm_count = job_->arm.disarm_count();
    return command;
  }
  intaglio_CommandAnswerCode CodeOf(const CommandView& command) {
    return arming_.Check(*job_, command).code;
  }
  bool Granted() { return arming_.Permissions(now_).at(0).granted; }
  TaskView Paused(intaglio_PauseReason reason, std::uint64_t total_count = 100) {
    TaskView task;
    task.state = intaglio_TASK_PAUSED;
    task.total_count = total_count;
    task.pause_reason = reason;
    task.message = "a sentence";
    return task;
  }

  Nanoseconds now_{100s};
  RecordingActions actions_;
  JobBook book_{actions_};
  WorkerBook workers_;
  PieceBook pieces_{actions_};
  MountBook mounts_;
  Arming arming_{book_, workers_, pieces_, mounts_};
  JobRecord* job_ = nullptr;
};

TEST_F(ArmingTest, WhatIsRefused) {
  EXPECT_EQ(CodeOf(Of(intaglio_COMMAND_ARM)), intaglio_ANSWER_TAKEN);
  CommandView command = Of(intaglio_COMMAND_PAUSE);
  command.epoch = 6;
  EXPECT_EQ(CodeOf(command), intaglio_ANSWER_WRONG_EPOCH);
  command = Of(intaglio_COMMAND_SPEED);
  for (const auto& [percent, code] :
       {std::pair{0u, intaglio_ANSWER_OUT_OF_RANGE}, std::pair{1u, intaglio_ANSWER_TAKEN},
        std::pair{140u, intaglio_ANSWER_TAKEN},
        std::pair{141u, intaglio_ANSWER_OUT_OF_RANGE}}) {
    command.speed_percent = percent;
    EXPECT_EQ(CodeOf(command), code) << percent;
  }
  const CommandView early = Of(intaglio_COMMAND_ARM);
  arming_.Pause(*job_, Of(intaglio_COMMAND_PAUSE), now_);
  EXPECT_EQ(CodeOf(early), intaglio_ANSWER_SUPERSEDED);
  job_->state = intaglio_JOB_QUEUED;
  EXPECT_EQ(CodeOf(Of(intaglio_COMMAND_RESUME)), intaglio_ANSWER_NOT_YET);
  EXPECT_EQ(CodeOf(Of(intaglio_COMMAND_CANCEL)), intaglio_ANSWER_TAKEN);
  job_->state = intaglio_JOB_DONE;
  EXPECT_EQ(CodeOf(Of(intaglio_COMMAND_CANCEL)), intaglio_ANSWER_ENDED_JOB);
}

TEST_F(ArmingTest, APermissionIsOfTheWorkerThatHasTheTask) {
  EXPECT_FALSE(Granted());
  arming_.Arm(*job_, Of(intaglio_COMMAND_ARM), now_);
  EXPECT_FALSE(Granted()) << "its warnings are not known";
  job_->stage(intaglio_STAGE_SORT).done = true;
  EXPECT_TRUE(Granted());
  EXPECT_TRUE(actions_.kept.at("j1").arm.ever_granted()) << "kept by then";
  workers_.Release("y", job_->TaskOf(intaglio_STAGE_ENGRAVE), now_);
  EXPECT_FALSE(Granted());
}

TEST_F(ArmingTest, NothingIsGrantedBeforeThePathIsThere) {
  arming_.Arm(*job_, Of(intaglio_COMMAND_ARM), now_);
  for (const auto state : {intaglio_JOB_DISCRETIZING, intaglio_JOB_SORTING}) {
    job_->state = state;
    EXPECT_FALSE(Granted());
  }
  EXPECT_FALSE(job_->arm.ever_granted());
}

TEST_F(ArmingTest, AStopDisarmsAndForbidsEveryArmUntilItIsReset) {
  arming_.Arm(*job_, Of(intaglio_COMMAND_ARM), now_);
  arming_.SetStop("c", true, now_);
  EXPECT_FALSE(job_->arm.armed());
  EXPECT_FALSE(Granted());
  EXPECT_EQ(CodeOf(Of(intaglio_COMMAND_ARM)), intaglio_ANSWER_STOP_PRESSED);
  arming_.Renew(*job_, now_);
  EXPECT_FALSE(job_->arm.armed());
  const std::uint64_t count = job_->arm.disarm_count();
  arming_.SetStop("c", true, now_);
  EXPECT_EQ(job_->arm.disarm_count(), count) << "the same press";
  arming_.SetStop("c", false, now_);
  EXPECT_FALSE(Granted());
  EXPECT_EQ(CodeOf(Of(intaglio_COMMAND_ARM)), intaglio_ANSWER_TAKEN);
}

// A fault spends the arm; a lost line renews it; a permission that ended does neither.
TEST_F(ArmingTest, WhatAPausedMachineDoesToTheArm) {
  for (int i = 0; i <= intaglio_PAUSE_LINE_LOST; ++i) {
    const auto reason = static_cast<intaglio_PauseReason>(i);
    if (reason == intaglio_PAUSE_NONE) continue;
    job_->state = intaglio_JOB_ENGRAVING;
    arming_.Arm(*job_, Of(intaglio_COMMAND_RESUME), now_);
    const std::uint64_t count = job_->arm.disarm_count();
    now_ += 1s;
    arming_.TakePaused(*job_, Paused(reason), now_);
    const bool fault = reason != intaglio_PAUSE_NOT_ARMED;
    EXPECT_EQ(job_->arm.disarm_count() > count, fault) << reason;
    EXPECT_EQ(job_->arm.armed(), !fault || reason == intaglio_PAUSE_LINE_LOST) << reason;
    EXPECT_EQ(job_->state, intaglio_JOB_PAUSED);
    EXPECT_EQ(job_->pause_reason, reason);
    now_ += 1s;
  }
}

TEST_F(ArmingTest, AFaultBeforeThePathSpendsTheArmAndKeepsTheState) {
  job_->state = intaglio_JOB_SORTING;
  arming_.Arm(*job_, Of(intaglio_COMMAND_ARM), now_);
  arming_.TakePaused(*job_, Paused(intaglio_PAUSE_INTERLOCK, 0), now_);
  EXPECT_TRUE(job_->arm.armed()) << "about the time before the arm";
  now_ += JobArm::kHold;
  arming_.TakePaused(*job_, Paused(intaglio_PAUSE_INTERLOCK, 0), now_);
  EXPECT_FALSE(job_->arm.armed());
  EXPECT_EQ(job_->state, intaglio_JOB_SORTING);
  EXPECT_EQ(job_->arm_loss, "a sentence");
}

TEST_F(ArmingTest, AFaultWhileItIsTakenUpIsWhyItIsPaused) {
  book_.ChangeToPaused(*job_, intaglio_PAUSE_SYNCHRONIZER_LOST, "");
  arming_.Arm(*job_, Of(intaglio_COMMAND_RESUME), now_);
  now_ += 1s;
  arming_.TakePaused(*job_, Paused(intaglio_PAUSE_MACHINE_CHANGED, 0), now_);
  EXPECT_FALSE(job_->arm.armed());
  EXPECT_EQ(job_->pause_reason, intaglio_PAUSE_MACHINE_CHANGED);
}

// A shop that is being opened reports its block a moment after the first arm.
TEST_F(ArmingTest, TheFirstReportOfAProgramEndsOnlyArmsOfJobsForSomethingElse) {
  FrozenJob frozen;
  Vector3& size_mm = *frozen.mutable_job()->mutable_block()->mutable_size_mm();
  size_mm.set_x(50);
  size_mm.set_y(50);
  size_mm.set_z(30);
  frozen.mutable_job()->mutable_lens()->set_numerical_aperture(0.06);
  job_->frozen_job = frozen.SerializeAsString();
  const auto armed_behind = [&](const Vec3& block_mm, intaglio_ArmBasis basis) {
    if (!job_->arm.armed()) arming_.Arm(*job_, Of(intaglio_COMMAND_ARM), now_);
    now_ += 1s;
    CommandView command = Of(intaglio_COMMAND_MOUNT);
    command.cell = "c";
    command.basis = basis;
    command.mounted.block_mm = block_mm;
    if (const auto mount = mounts_.RecordFor(command, ""))
      arming_.SetMount(*mount, basis, now_);
    return job_->arm.armed();
  };
  EXPECT_TRUE(armed_behind({50, 50, 30}, intaglio_ARM_BY_PROGRAM)) << "what was armed";
  EXPECT_TRUE(armed_behind({50, 50, 30}, intaglio_ARM_BY_PROGRAM)) << "repeated";
  EXPECT_FALSE(armed_behind({60, 60, 30}, intaglio_ARM_BY_PROGRAM)) << "another one";
  EXPECT_FALSE(armed_behind({60, 60, 30}, intaglio_ARM_BY_PERSON)) << "changed";
  mounts_ = MountBook();
  EXPECT_FALSE(armed_behind({50, 50, 30}, intaglio_ARM_BY_PERSON)) << "a first one";
  mounts_ = MountBook();
  EXPECT_FALSE(armed_behind({50, 50, 40}, intaglio_ARM_BY_PROGRAM)) << "too high";
  EXPECT_THAT(job_->message, testing::HasSubstr("50 x 50 x 40 mm"));
}

TEST_F(ArmingTest, OnlyArmsWithAReasonEnd) {
  arming_.Arm(*job_, Of(intaglio_COMMAND_ARM), now_);
  arming_.EndArms(intaglio_PAUSE_CLOSED, now_,
                  [](const JobRecord&) { return std::string(); });
  EXPECT_TRUE(job_->arm.armed());
  job_->state = intaglio_JOB_ENGRAVING;
  arming_.EndArms(intaglio_PAUSE_CLOSED, now_,
                  [](const JobRecord&) { return std::string("the shop was closed"); });
  EXPECT_FALSE(job_->arm.armed());
  EXPECT_EQ(job_->pause_reason, intaglio_PAUSE_CLOSED);
}

}  // namespace
}  // namespace intaglio::job_service
