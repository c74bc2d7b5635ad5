// A synchronizer, a line or the job service itself is lost while pulses are in the glass.

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class TakeUpTest : public JobQueueTest {
 protected:
  void EngraveAndLose() {
    ReadyAll();
    Add(1);
    LoadPath();
    Engrave();
    actions_.Orders();
    Lose("y");
  }
  void NextSynchronizer() {
    Ready("y2", intaglio_ROLE_SYNCHRONIZER);
    queue_.Turn(now_);
  }
  /// And another synchronizer takes the job up.
  void BeAwayFor(std::chrono::seconds absence) {
    EngraveAndLose();
    for (auto waited = 0s; waited < absence; waited += 1s) {
      now_ += 1s;
      queue_.Turn(now_);
    }
    NextSynchronizer();
    now_ += 1s;
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 50, 100, intaglio_PAUSE_NOT_ARMED,
         "waits for the arm");
    now_ += 5s;
    queue_.Turn(now_);
  }
  /// `sorting`: the points are there, and are put in order.
  void OpenTheDoorBeforeThePath(bool sorting) {
    ReadyAll();
    Add(1);
    if (sorting) DiscretizeAll();
    const auto state = job().state;
    ASSERT_TRUE(Command(intaglio_COMMAND_ARM));
    now_ += 1s;
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 0, 0, intaglio_PAUSE_FAULT,
         "the door is open");
    EXPECT_FALSE(job().arm.armed());
    EXPECT_EQ(job().state, state) << "the points are made all the same";
    EXPECT_EQ(job().message, "the door is open");
    LoadPath();
    now_ += 1s;
    EXPECT_FALSE(Granted());
    ASSERT_TRUE(Command(intaglio_COMMAND_ARM));
    now_ += 1s;
    EXPECT_TRUE(Granted());
  }
  void Lost() {
    Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_LINE_LOST,
         "the laser line is down");
  }
};

TEST_F(TakeUpTest, TheNextSynchronizerTakesItUpAndItGoesOn) {
  EngraveAndLose();
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_THAT(job().message, HasSubstr("the next synchronizer of c continues the job"));
  EXPECT_FALSE(Granted());
  actions_.Orders();
  NextSynchronizer();
  EXPECT_THAT(actions_.Orders(), ElementsAre("take up y2 j1 1"));
  now_ += 1s;
  EXPECT_TRUE(Granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 50, 100);
  EXPECT_EQ(job().state, intaglio_JOB_ENGRAVING);
  EXPECT_EQ(job().attempt, 1u);
}

// The network was away for longer than a lease, and the same synchronizer is back.
TEST_F(TakeUpTest, ALateReportOnTheRevocationIsNotOneOnTheJob) {
  EngraveAndLose();
  actions_.Orders();
  now_ += 2s;
  Ready("y", intaglio_ROLE_SYNCHRONIZER);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("take up y j1 1"));
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_FAILED, 12, 100, intaglio_ERROR_CANCELLED,
       "the job was cancelled");
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  now_ += 1s;
  EXPECT_TRUE(Granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 50, 100);
  EXPECT_EQ(job().state, intaglio_JOB_ENGRAVING);
}

TEST_F(TakeUpTest, WhoAsksIsWaitedFor) {
  ReadyAll();
  JobRecord record;
  record.number = 1;
  record.uid = "j1";
  record.epoch = kEpoch;
  record.cell = "c";
  record.arm = JobArm({.asks_before_resume = true});
  queue_.Add(record);
  queue_.Turn(now_);
  LoadPath();
  Engrave();
  Lose("y");
  EXPECT_THAT(job().message, HasSubstr("then resume it"));
  NextSynchronizer();
  now_ += 5s;
  EXPECT_FALSE(Granted());
  Ready("y2", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  now_ += 1s;
  EXPECT_TRUE(Granted());
}

TEST_F(TakeUpTest, AJobThatWasPausedStaysPaused) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  Lose("y");
  NextSynchronizer();
  now_ += 60s;
  EXPECT_FALSE(Granted());
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
}

TEST_F(TakeUpTest, ItsBlockKeepsTheMachine) {
  EngraveAndLose();
  Add(2);
  NextSynchronizer();
  EXPECT_EQ(queue_.Find("j2")->state, intaglio_JOB_QUEUED);
  EXPECT_TRUE(Command(intaglio_COMMAND_CANCEL));
  EXPECT_EQ(job().state, intaglio_JOB_CANCELLED);
}

// It only seemed lost: its task is revoked, and it may take it up itself.
TEST_F(TakeUpTest, AFrozenSynchronizerLetsGoBeforeItTakesItUpAgain) {
  EngraveAndLose();
  EXPECT_THAT(actions_.Orders(), Contains("revoke y j1 1"));
  Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), IsEmpty());
  TaskView over;
  over.task = {"j1", 1, 0, 0};
  over.stage = intaglio_STAGE_ENGRAVE;
  over.worker = "y";
  over.state = intaglio_TASK_FAILED;
  over.error_code = intaglio_ERROR_CANCELLED;
  queue_.Receive(over, now_);
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED) << "its end is not the job's";
  Ready("y", intaglio_ROLE_SYNCHRONIZER);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("take up y j1 1"));
}

// The folder may be away for a while: what is in the glass is not.
TEST_F(TakeUpTest, AMissingPathFailsTheJobAndEngravesNothingAnew) {
  EngraveAndLose();
  NextSynchronizer();
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_FAILED, 0, 0, intaglio_ERROR_NOT_FOUND,
       "path.ply is not there");
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().attempt, 1u);
  EXPECT_EQ(job().message, "path.ply is not there");
}

// The restart falls between the loss and the next synchronizer, and the lost one is back.
TEST_F(TakeUpTest, AfterARestartTheLostOnesLastReportIsNotOneOnTheJob) {
  EngraveAndLose();
  RecordingActions actions;
  JobQueue queue(actions);
  queue.Restore({actions_.kept.at("j1")}, 2s, now_);
  TaskView late;
  late.task = {"j1", 1, 0, 0};
  late.stage = intaglio_STAGE_ENGRAVE;
  late.worker = "y";
  late.state = intaglio_TASK_FAILED;
  late.error_code = intaglio_ERROR_CANCELLED;
  queue.Receive(late, now_);
  EXPECT_EQ(queue.Find("j1")->state, intaglio_JOB_PAUSED);
  queue.Receive(
      WorkerView{"y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "c", ""}, now_);
  queue.Turn(now_);
  EXPECT_THAT(actions.Orders(), ElementsAre("take up y j1 1"));
  EXPECT_TRUE(queue.Permissions(now_ + 4s).at(0).granted);
}

// Resumed, and a fault before it has begun: the state is the same, the arm is not.
TEST_F(TakeUpTest, AFaultWhilePausedIsKept) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const auto open_door = [this] {
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_INTERLOCK,
         "the door");
  };
  now_ += 1s;
  open_door();
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  ASSERT_EQ(job().state, intaglio_JOB_PAUSED);
  ASSERT_TRUE(actions_.kept.at("j1").arm.armed());
  now_ += 2s;
  open_door();
  EXPECT_FALSE(actions_.kept.at("j1").arm.armed());
}

TEST_F(TakeUpTest, AJournalOfAnotherPathFailsTheJob) {
  EngraveAndLose();
  NextSynchronizer();
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_FAILED, 0, 0, intaglio_ERROR_REFUSED,
       "take the block out");
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().message, "take the block out");
}

// A withdrawal lasts long enough to be seen, and then the job is armed again.
TEST_F(TakeUpTest, ALostLineIsResumedByItself) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  now_ += 1s;
  Lost();
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_TRUE(job().arm.armed());
  EXPECT_FALSE(Granted());
  now_ += 250ms;
  EXPECT_FALSE(Granted());
  now_ += 51ms;
  EXPECT_TRUE(Granted());
}

// A line that is lost again and again: it is tried for a minute, then a person has to
// come.
TEST_F(TakeUpTest, ALineThatDoesNotHoldIsGivenUp) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  int grants = 0;
  bool granted = false;
  for (int i = 0; i < 3 * 600; ++i) {
    now_ += 100ms;
    Lost();
    const bool is = Granted();
    grants += is && !granted ? 1 : 0;
    granted = is;
  }
  EXPECT_EQ(grants, 20);
  EXPECT_FALSE(job().arm.armed());
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  EXPECT_TRUE(job().arm.armed());
}

TEST_F(TakeUpTest, AJobServiceThatWasAwayForAMomentGoesOn) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const JobRecord kept = actions_.kept.at("j1");
  ASSERT_TRUE(kept.arm.armed());
  for (const auto& [absence, goes_on] :
       {std::pair<std::optional<Nanoseconds>, bool>{2s, true},
        {28s, true},
        {30s, false},  // nothing was received from the synchronizer, either
        {31s, false},
        {std::nullopt, false}}) {
    RecordingActions actions;
    JobQueue queue(actions);
    queue.Restore({kept}, absence, now_);
    queue.Turn(now_ + 500ms);
    EXPECT_EQ(queue.Find("j1")->state, intaglio_JOB_PAUSED);
    EXPECT_FALSE(queue.Permissions(now_).at(0).granted);
    EXPECT_EQ(queue.Permissions(now_ + 1s).at(0).granted, goes_on);
  }
}

// Host and laser are switched off in mid-job, the block is changed, and next morning the
// host is back. The job service ran elsewhere all the time.
TEST_F(TakeUpTest, AnArmDoesNotOutliveALongAbsenceOfTheSynchronizer) {
  BeAwayFor(35s);
  EXPECT_FALSE(Granted());
  EXPECT_FALSE(actions_.kept.at("j1").arm.armed());
  EXPECT_THAT(job().message, HasSubstr("resume it if the block was not touched"));
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  now_ += 1s;
  EXPECT_TRUE(Granted());
}

// Armed before the next synchronizer is there: the absence before it does not count.
TEST_F(TakeUpTest, AnArmDuringAnAbsenceIsOneOfThatMoment) {
  EngraveAndLose();
  for (int i = 0; i < 60; ++i) {
    now_ += 1s;
    queue_.Turn(now_);
  }
  ASSERT_FALSE(job().arm.armed());
  ASSERT_TRUE(Command(intaglio_COMMAND_RESUME));
  now_ += 2s;
  queue_.Turn(now_);
  EXPECT_TRUE(job().arm.armed());
  NextSynchronizer();
  EXPECT_TRUE(Granted());
}

TEST_F(TakeUpTest, AnArmOutlivesAShortAbsenceOfTheSynchronizer) {
  BeAwayFor(25s);
  EXPECT_TRUE(Granted());
}

// The computer slept, or the process was stopped: it is not known what happened
// meanwhile.
TEST_F(TakeUpTest, AJobServiceThatWasFrozenForLongDisarms) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  queue_.Turn(now_);
  EXPECT_TRUE(Granted());
  now_ += 31s;
  Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
  queue_.Turn(now_);
  EXPECT_FALSE(Granted());
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_THAT(job().message, HasSubstr("the job service was absent"));
}

TEST_F(TakeUpTest, ClosingTheShopEndsEveryArm) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  queue_.Close(now_);
  EXPECT_FALSE(Granted());
  const JobRecord& kept = actions_.kept.at("j1");
  EXPECT_FALSE(kept.arm.armed());
  EXPECT_EQ(kept.state, intaglio_JOB_PAUSED);
  EXPECT_THAT(kept.message, HasSubstr("the shop was closed"));
}

TEST_F(TakeUpTest, ClosingACellEndsItsArm) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_STOPPING);
  EXPECT_FALSE(Granted());
  Lose("y");
  NextSynchronizer();
  now_ += 5s;
  EXPECT_FALSE(Granted());
  EXPECT_FALSE(job().arm.armed());
}

// A restart would find an arm without knowing how long it was unwatched.
TEST_F(TakeUpTest, AnArmWithoutASynchronizerIsNotKeptOverARestart) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  EXPECT_TRUE(job().arm.ToKeep().armed);
  Lose("y");
  EXPECT_TRUE(job().arm.armed());
  EXPECT_FALSE(job().arm.ToKeep().armed);
  NextSynchronizer();
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 50, 100);
  EXPECT_TRUE(actions_.kept.at("j1").arm.ToKeep().armed);
}

TEST_F(TakeUpTest, ADoorOpenedWhileThePointsAreMadeCostsTheArm) {
  OpenTheDoorBeforeThePath(false);
}

TEST_F(TakeUpTest, ADoorOpenedWhileThePointsAreSortedCostsTheArm) {
  OpenTheDoorBeforeThePath(true);
}

// Everything died: who is there now takes the place of who is not.
TEST_F(TakeUpTest, AfterARestartAnotherSynchronizerTakesItUp) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  RecordingActions actions;
  JobQueue queue(actions);
  queue.Restore({actions_.kept.at("j1")}, std::nullopt, now_);
  queue.Receive(
      WorkerView{"y2", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "c", ""}, now_);
  queue.Turn(now_);
  EXPECT_THAT(actions.Orders(), ElementsAre("take up y2 j1 1"));
}

}  // namespace
}  // namespace intaglio::job_service
