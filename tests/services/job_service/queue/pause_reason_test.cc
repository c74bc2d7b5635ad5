// Why a job is paused, as a code by which clients decide, independent of the text of the
// messages.

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

class PauseReasonTest : public JobQueueTest {
 protected:
  void RunToEngraving() {
    ReadyAll();
    Add(1);
    LoadPath();
    Engrave();
    EXPECT_EQ(job().pause_reason, intaglio_PAUSE_NONE);
  }
  void Paused(intaglio_PauseReason reason) {
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, reason, "a sentence");
  }
  void ExpectPaused(intaglio_PauseReason reason) {
    EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
    EXPECT_EQ(job().pause_reason, reason);
    EXPECT_EQ(actions_.kept.at("j1").pause_reason, reason) << "a restart knows it";
  }
};

TEST_F(PauseReasonTest, APersonsPauseLastsUntilItRunsAgain) {
  RunToEngraving();
  ASSERT_TRUE(Command(intaglio_COMMAND_PAUSE));
  ExpectPaused(intaglio_PAUSE_OPERATOR);
  Paused(intaglio_PAUSE_NOT_ARMED);  // the machine has halted, too
  ExpectPaused(intaglio_PAUSE_OPERATOR);
  ASSERT_TRUE(Command(intaglio_COMMAND_RESUME));
  now_ += 1s;
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 13, 100);
  EXPECT_EQ(job().state, intaglio_JOB_ENGRAVING);
  EXPECT_EQ(job().pause_reason, intaglio_PAUSE_NONE);
}

TEST_F(PauseReasonTest, OfAMachineThatHaltsItsOwnReasonCounts) {
  RunToEngraving();
  for (const intaglio_PauseReason reason :
       {intaglio_PAUSE_FAULT, intaglio_PAUSE_EMERGENCY_STOP, intaglio_PAUSE_INTERLOCK,
        intaglio_PAUSE_MACHINE_CHANGED, intaglio_PAUSE_UNCERTAIN_POINTS,
        intaglio_PAUSE_LINE_LOST}) {
    SCOPED_TRACE(reason);
    now_ += 1s;
    Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
    Paused(reason);
    ExpectPaused(reason);
    EXPECT_EQ(job().arm.armed(), reason == intaglio_PAUSE_LINE_LOST)
        << "only a lost line is got over without a person";
    ASSERT_TRUE(Command(intaglio_COMMAND_RESUME));
    now_ += 1s;
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 13, 100);
    EXPECT_EQ(job().pause_reason, intaglio_PAUSE_NONE);
  }
}

TEST_F(PauseReasonTest, AFaultReplacesAPersonsPause) {
  RunToEngraving();
  ASSERT_TRUE(Command(intaglio_COMMAND_PAUSE));
  Paused(intaglio_PAUSE_INTERLOCK);
  EXPECT_EQ(job().pause_reason, intaglio_PAUSE_INTERLOCK);
}

TEST_F(PauseReasonTest, OfALostSynchronizer) {
  RunToEngraving();
  Lose("y");
  ExpectPaused(intaglio_PAUSE_SYNCHRONIZER_LOST);
  now_ += 31s;
  queue_.Turn(now_);
  ExpectPaused(intaglio_PAUSE_ABSENCE);
}

TEST_F(PauseReasonTest, OfAShopThatIsClosed) {
  RunToEngraving();
  queue_.Close(now_);
  ExpectPaused(intaglio_PAUSE_CLOSED);
}

TEST_F(PauseReasonTest, OfAStopWhileItIsPausedAndArmed) {
  RunToEngraving();
  now_ += 1s;
  Paused(intaglio_PAUSE_LINE_LOST);
  queue_.SetStop("c", true, now_);
  ExpectPaused(intaglio_PAUSE_EMERGENCY_STOP);
}

TEST_F(PauseReasonTest, ARestartKeepsAPersonsReasonAndIsOneOtherwise) {
  RunToEngraving();
  JobRecord engraving = actions_.kept.at("j1");
  ASSERT_TRUE(Command(intaglio_COMMAND_PAUSE));
  for (const JobRecord& before : {engraving, actions_.kept.at("j1")}) {
    JobQueue next(actions_);
    next.Restore({before}, std::nullopt, now_);
    EXPECT_EQ(next.Find("j1")->state, intaglio_JOB_PAUSED);
    EXPECT_EQ(next.Find("j1")->pause_reason, before.state == intaglio_JOB_PAUSED
                                                 ? intaglio_PAUSE_OPERATOR
                                                 : intaglio_PAUSE_RESTART);
  }
}

}  // namespace
}  // namespace intaglio::job_service
