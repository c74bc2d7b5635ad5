// TakeUp alone; with the rest of the queue: take_up_test.cc.

#include "services/job_service/queue/take_up.h"
#include "services/platform/host/safety/absence_limit.h"
#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

class TakeUpUnitTest : public testing::Test {
 protected:
  TakeUpUnitTest() {
    JobRecord job;
    job.uid = "j1";
    job.cell = "c";
    job.attempt = 1;
    job.state = intaglio_JOB_ENGRAVING;
    job.stage(intaglio_STAGE_ENGRAVE).worker = "y";
    job.arm = JobArm({.armed = true, .ever_granted = true});
    job_ = &book_.Add(job);
    actions_.kept["j1"] = *job_;
    tasks_.Give(*job_, intaglio_STAGE_ENGRAVE, "y", {}, now_);
    actions_.Orders();
  }
  void Ready(const std::string& synchronizer) {
    tasks_.workers().Update(
        {synchronizer, intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "c", ""}, now_);
  }
  void ExpectPaused(intaglio_PauseReason reason, bool armed) {
    EXPECT_EQ(job_->state, intaglio_JOB_PAUSED);
    EXPECT_EQ(job_->pause_reason, reason);
    EXPECT_EQ(job_->arm.armed(), armed);
  }

  Nanoseconds now_{100s};
  RecordingActions actions_;
  JobBook book_{actions_};
  TaskHandout tasks_{actions_};
  PieceBook pieces_{actions_};
  MountBook mounts_;
  Arming arming_{book_, tasks_.workers(), pieces_, mounts_};
  TakeUp take_up_{book_, tasks_, arming_};
  JobRecord* job_ = nullptr;
};

TEST_F(TakeUpUnitTest, TheNextSynchronizerGetsWhatTheLostOneHad) {
  take_up_.Lose(*job_, "y was lost", now_);
  ExpectPaused(intaglio_PAUSE_SYNCHRONIZER_LOST, true);
  EXPECT_THAT(actions_.Orders(), testing::ElementsAre("stop j1", "revoke y j1 1"));
  take_up_.GiveToFree(*job_, now_);
  EXPECT_THAT(actions_.Orders(), testing::IsEmpty()) << "there is none";
  Ready("z");
  take_up_.GiveToFree(*job_, now_);
  EXPECT_THAT(actions_.Orders(), testing::ElementsAre("take up z j1 1"));
  take_up_.GiveToFree(*job_, now_);
  EXPECT_THAT(actions_.Orders(), testing::IsEmpty()) << "it has it";
}

TEST_F(TakeUpUnitTest, AJobWithoutPulsesInTheGlassIsNotTakenUp) {
  job_->state = intaglio_JOB_PAUSED;
  job_->arm = JobArm();
  Ready("z");
  take_up_.GiveToFree(*job_, now_);
  EXPECT_THAT(actions_.Orders(), testing::IsEmpty());
}

TEST_F(TakeUpUnitTest, AnAbsenceEndsTheArmAfterItsLimitAndNotBefore) {
  take_up_.EndAbsences(now_);
  take_up_.Lose(*job_, "y was lost", now_);
  for (const Nanoseconds step :
       {Nanoseconds(host::kMaxAbsence) - 1s, Nanoseconds(1s), Nanoseconds(1ns)}) {
    ExpectPaused(intaglio_PAUSE_SYNCHRONIZER_LOST, true);
    now_ += step;
    take_up_.EndAbsences(now_);
  }
  ExpectPaused(intaglio_PAUSE_ABSENCE, false);
}

// This process itself was stopped.
TEST_F(TakeUpUnitTest, SoDoesALongTimeBetweenTwoTurns) {
  take_up_.EndAbsences(now_);
  now_ += host::kMaxAbsence;
  take_up_.EndAbsences(now_);
  EXPECT_TRUE(job_->arm.armed());
  now_ += host::kMaxAbsence + 1ns;
  take_up_.EndAbsences(now_);
  ExpectPaused(intaglio_PAUSE_ABSENCE, false);
}

TEST_F(TakeUpUnitTest, SoDoTwoShorterTimesWithLessThanTheLimitBetweenThem) {
  for (const bool rests_between : {true, false}) {
    take_up_.EndAbsences(now_);
    now_ += 25s;
    take_up_.EndAbsences(now_);
    for (const Nanoseconds end = now_ + (rests_between ? 30s : 1s); now_ < end;) {
      now_ += 500ms;
      take_up_.EndAbsences(now_);
    }
    now_ += 25s;
    take_up_.EndAbsences(now_);
    EXPECT_EQ(job_->arm.armed(), rests_between);
    for (int i = 0; rests_between && i < 60; ++i) {
      now_ += 500ms;
      take_up_.EndAbsences(now_);
    }
  }
}

TEST_F(TakeUpUnitTest, ClosingACellEndsItsArmAlone) {
  take_up_.CloseCell("another", now_);
  EXPECT_TRUE(job_->arm.armed());
  take_up_.CloseCell("y", now_);
  ExpectPaused(intaglio_PAUSE_CLOSED, false);
}

TEST_F(TakeUpUnitTest, RestoresWithOrWithoutTheArm) {
  for (const bool arm_counts : {false, true}) {
    job_->state = intaglio_JOB_ENGRAVING;
    job_->arm = JobArm({.armed = true, .ever_granted = true});
    take_up_.Restore(*job_, arm_counts, now_);
    ExpectPaused(intaglio_PAUSE_RESTART, arm_counts);
    EXPECT_TRUE(tasks_.workers().IsAssigned("y", job_->TaskOf(intaglio_STAGE_ENGRAVE)));
  }
}

TEST_F(TakeUpUnitTest, AnOldAnswerIsOneOfWhoWasGivenTheJobAnew) {
  TaskView answer;
  answer.task = job_->TaskOf(intaglio_STAGE_ENGRAVE);
  answer.stage = intaglio_STAGE_ENGRAVE;
  answer.worker = "y";
  answer.state = intaglio_TASK_FAILED;
  answer.error_code = intaglio_ERROR_CANCELLED;
  EXPECT_FALSE(take_up_.AnswersAnOldRevocation(answer)) << "it was given once";
  job_->taken_up = true;
  EXPECT_TRUE(take_up_.AnswersAnOldRevocation(answer));
  answer.error_code = intaglio_ERROR_FAULT;
  EXPECT_FALSE(take_up_.AnswersAnOldRevocation(answer)) << "a failure of its own";
}

}  // namespace
}  // namespace intaglio::job_service
