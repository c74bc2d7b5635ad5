#include "services/job_service/job_queue.h"

#include "tests/services/job_service/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(JobQueueTest, HappyPath) {
  ReadyAll();
  Add(1);
  EXPECT_THAT(actions_.Orders(), ElementsAre("y j1 1", "s j1 1 > y", "d j1 1 > s"));
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  Task(intaglio_STAGE_DISCRETIZE, intaglio_TASK_RUNNING, 50, 100);
  EXPECT_EQ(job().stage(intaglio_STAGE_DISCRETIZE).done_count, 500u);
  EXPECT_EQ(job().stage(intaglio_STAGE_DISCRETIZE).total_count, 1000u);
  Task(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100, 100);
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
  Task(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100, 100);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_ACCEPTED);
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, "", "waits for the arm");
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_EQ(job().message, "waits for the arm");
  EXPECT_EQ(job().estimate_ticks, 77u);
  EXPECT_FALSE(Granted());
  Engrave();
  EXPECT_TRUE(actions_.kept.at("j1").ever_granted);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100, 100);
  EXPECT_EQ(job().state, intaglio_JOB_DONE);
  EXPECT_FALSE(Granted());
  EXPECT_THAT(actions_.Orders(), ElementsAre("stop j1", "stop j1"))
      << "when the points are made, and at the end";
}

TEST_F(JobQueueTest, WaitsForWorkersAndSaysWhich) {
  Add(1);
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_EQ(
      job().message,
      "waits for a synchronizer of c (none runs), a sorter (none runs), a discretizer "
      "(none runs)");
  ReadyAll();
  Ready("s", intaglio_ROLE_SORTER, intaglio_HEALTH_BUSY);
  queue_.Turn(now_);
  EXPECT_EQ(job().message, "waits for a sorter (all are busy)");
  Ready("s", intaglio_ROLE_SORTER);
  queue_.Turn(now_);
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
}

TEST_F(JobQueueTest, OneJobAtATimeHasACell) {
  ReadyAll();
  Ready("d2", intaglio_ROLE_DISCRETIZER);
  Ready("s2", intaglio_ROLE_SORTER);
  Ready("y2", intaglio_ROLE_SYNCHRONIZER);
  Add(1);
  Add(2);
  EXPECT_THAT(queue_.Find("j2")->message, HasSubstr("waits for its turn on c"));
  LoadPath();
  EXPECT_EQ(queue_.Find("j2")->state, intaglio_JOB_QUEUED);
  Engrave();
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100, 100);
  EXPECT_EQ(queue_.Find("j2")->state, intaglio_JOB_DISCRETIZING);
}

// The block in the machine is the first job's: an arm for the second is not kept until
// the machine is free, when that block would still be in it.
TEST_F(JobQueueTest, OfThoseThatWaitTheHighestPriorityIsNext) {
  Add(1);
  Add(2, "c", -1);
  Add(3);
  Add(4, "c", 7);
  const auto waits = HasSubstr("waits for its turn");
  EXPECT_THAT(queue_.Find("j1")->message, waits);
  EXPECT_THAT(queue_.Find("j4")->message, testing::Not(waits));
  ReadyAll();
  queue_.Turn(now_);
  EXPECT_EQ(queue_.Find("j4")->state, intaglio_JOB_DISCRETIZING);
  // What is under way stays; the others follow by priority, then by number.
  Add(5, "c", 9);
  for (const char* next : {"j5", "j1", "j3", "j2"}) {
    for (const auto& [uid, job] : queue_.jobs()) {
      if (!job.active()) continue;
      queue_.Take(CommandView{uid, kEpoch, ++command_, intaglio_COMMAND_CANCEL, "ann"},
                  now_);
      break;
    }
    ReadyAll();
    now_ += 2s;
    ReadyAll();
    queue_.Turn(now_);
    EXPECT_EQ(queue_.Find(next)->state, intaglio_JOB_DISCRETIZING) << next;
  }
}

TEST_F(JobQueueTest, AJobBehindAnotherCannotBeArmed) {
  Add(1);
  Add(2);
  queue_.Take(CommandView{"j2", kEpoch, 1, intaglio_COMMAND_ARM, "ann@shop"}, now_);
  EXPECT_FALSE(queue_.Find("j2")->armed) << "the first waits for workers";
  ReadyAll();
  queue_.Turn(now_);
  const std::uint64_t revision = queue_.Find("j2")->revision;
  queue_.Take(CommandView{"j2", kEpoch, 2, intaglio_COMMAND_ARM, "ann@shop"}, now_);
  EXPECT_FALSE(queue_.Find("j2")->armed);
  EXPECT_GT(queue_.Find("j2")->revision, revision) << "the command is answered";
  EXPECT_THAT(queue_.Find("j2")->message, HasSubstr("arm it then"));
}

TEST_F(JobQueueTest, AnotherCellGoesOnMeanwhile) {
  ReadyAll();
  Ready("s2", intaglio_ROLE_SORTER);
  queue_.Take(WorkerView{"z", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "e", ""},
              now_);
  Add(1);
  Ready("d2", intaglio_ROLE_DISCRETIZER);
  Add(2, "e");
  EXPECT_EQ(queue_.Find("j2")->state, intaglio_JOB_DISCRETIZING);
  EXPECT_EQ(queue_.Find("j2")->stage(intaglio_STAGE_ENGRAVE).worker, "z");
}

TEST_F(JobQueueTest, LostWorkerMeansANewAttempt) {
  ReadyAll();
  Ready("s2", intaglio_ROLE_SORTER);
  Add(1);
  actions_.Orders();
  Lose("s");
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("stop j1", "revoke d j1 1", "revoke s j1 1", "revoke y j1 1"));
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_THAT(job().message, HasSubstr("attempt 1 broke: s was lost; waits for"));
  // The discretizer says that it has dropped the old attempt; the synchronizer never got
  // it.
  TaskView dropped = SortStatus(1, intaglio_TASK_FAILED);
  dropped.stage = intaglio_STAGE_DISCRETIZE;
  dropped.worker = "d";
  queue_.Take(dropped, now_);
  now_ += 500ms;
  ReadyAll();
  queue_.Turn(now_);
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED) << "the synchronizer may still be at it";
  now_ += 600ms;
  Ready("y", intaglio_ROLE_SYNCHRONIZER);
  Lose("s");  // came back in ReadyAll; gone for good now
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("y j1 2", "s2 j1 2 > y", "d j1 2 > s2"));
  EXPECT_THAT(job().message, HasSubstr("attempt 2: attempt 1 broke: s was lost"));
}

// A worker on a busy host may miss its heartbeats and go on.
TEST_F(JobQueueTest, AWorkerThatSeemedLostIsRidOfItsTaskAndUsedAgain) {
  ReadyAll();
  Add(1);
  LoadPath();
  actions_.Orders();
  Lose("y");
  EXPECT_THAT(actions_.Orders(), Contains("revoke y j1 1"));
  now_ += 5s;
  Ready("d", intaglio_ROLE_DISCRETIZER);
  Ready("s", intaglio_ROLE_SORTER);
  Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
  queue_.Turn(now_);
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED) << "it has not dropped the task yet";
  TaskView dropped = SortStatus(1, intaglio_TASK_FAILED);
  dropped.stage = intaglio_STAGE_ENGRAVE;
  dropped.worker = "y";
  queue_.Take(dropped, now_);
  Ready("y", intaglio_ROLE_SYNCHRONIZER);
  queue_.Turn(now_);
  EXPECT_EQ(job().attempt, 2u);
  EXPECT_EQ(job().stage(intaglio_STAGE_ENGRAVE).worker, "y");
}

TEST_F(JobQueueTest, OldAttemptsAreNotHeard) {
  ReadyAll();
  Ready("y2", intaglio_ROLE_SYNCHRONIZER);
  Add(1);
  Lose("y");
  const TaskView late = SortStatus(1, intaglio_TASK_DONE);
  queue_.Take(late, now_);
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_FALSE(job().stage(intaglio_STAGE_SORT).done);
  now_ += 2s;
  Ready("d", intaglio_ROLE_DISCRETIZER);
  Ready("s", intaglio_ROLE_SORTER);
  queue_.Turn(now_);
  ASSERT_EQ(job().attempt, 2u);
  queue_.Take(late, now_);
  EXPECT_FALSE(job().stage(intaglio_STAGE_SORT).done);
}

TEST_F(JobQueueTest, TheThirdLossFailsTheJob) {
  Add(1);
  for (int i = 1; i <= 3; ++i) {
    ReadyAll();
    now_ += 2s;
    ReadyAll();
    queue_.Turn(now_);
    ASSERT_EQ(job().attempt, static_cast<std::uint32_t>(i));
    Lose("s");
  }
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_THAT(job().message,
              HasSubstr("given up after 3 attempts; attempt 3 broke: s was lost"));
}

TEST_F(JobQueueTest, AWorkerThatIsDoneMayGo) {
  ReadyAll();
  Add(1);
  LoadPath();
  Lose("d");
  Lose("s");
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_EQ(job().attempt, 1u);
}

TEST_F(JobQueueTest, LostSynchronizerBeforeAnyPermissionIsAnotherAttempt) {
  ReadyAll();
  Add(1);
  LoadPath();
  Lose("y");
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
}

TEST_F(JobQueueTest, FailuresOfAStage) {
  ReadyAll();
  Add(1);
  Task(intaglio_STAGE_DISCRETIZE, intaglio_TASK_FAILED, 0, 0, "unreadable",
       "cube.stl is empty");
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().message, "cube.stl is empty");
}

TEST_F(JobQueueTest, AFailureThatANeighboursDeathCausesIsTriedAgain) {
  ReadyAll();
  Add(1);
  Task(intaglio_STAGE_SORT, intaglio_TASK_FAILED, 0, 0, "link_lost", "no points come");
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_EQ(job().lost_attempts, 1u);
}

TEST_F(JobQueueTest, AWorkerThatDoesNotAnswerCountsAsLost) {
  ReadyAll();
  Add(1);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_ACCEPTED);
  Task(intaglio_STAGE_SORT, intaglio_TASK_ACCEPTED);
  now_ += 9s;
  ReadyAll();
  queue_.Turn(now_);
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  now_ += 2s;
  queue_.Turn(now_);
  EXPECT_THAT(job().message, HasSubstr("d does not answer"));
}

TEST_F(JobQueueTest, AWorkerWhoseLoopHangsCountsAsLost) {
  ReadyAll();
  Add(1);
  for (const auto stage :
       {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
    Task(stage, intaglio_TASK_ACCEPTED);
  }
  now_ += 9s;
  Ready("d", intaglio_ROLE_DISCRETIZER, intaglio_HEALTH_BUSY);
  Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
  queue_.Turn(now_);
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  now_ += 2s;
  queue_.Turn(now_);
  EXPECT_THAT(job().message, HasSubstr("s does not answer"));
}

TEST_F(JobQueueTest, StaleCommandsDoNothing) {
  ReadyAll();
  Add(1);
  LoadPath();
  EXPECT_FALSE(Command(intaglio_COMMAND_ARM, kEpoch - 1));
  EXPECT_FALSE(
      queue_.Take(CommandView{"j9", kEpoch, 50, intaglio_COMMAND_ARM, ""}, now_));
  command_ = 4;
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  EXPECT_FALSE(queue_.Take(CommandView{"j1", kEpoch, 5, intaglio_COMMAND_ARM, ""}, now_));
  EXPECT_FALSE(queue_.Take(CommandView{"j1", kEpoch, 4, intaglio_COMMAND_ARM, ""}, now_));
  now_ += 1s;
  EXPECT_FALSE(Granted());
  EXPECT_EQ(actions_.kept.at("j1").last_command, 5u);
}

TEST_F(JobQueueTest, ArmedAheadIsGrantedOnlyWhenThePathIsThere) {
  ReadyAll();
  Add(1);
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  now_ += 1s;
  EXPECT_FALSE(Granted());
  LoadPath();
  EXPECT_TRUE(Granted());
}

TEST_F(JobQueueTest, TakesASpeedWithinItsRangeAndTellsTheCell) {
  ReadyAll();
  Add(1);
  LoadPath();
  const auto told = [this] { return queue_.Permissions(now_).at(0).speed_percent; };
  EXPECT_EQ(told(), 100u);
  EXPECT_TRUE(queue_.Take(SpeedView{"j1", kEpoch, 7, 30, "ann@shop"}));
  EXPECT_EQ(told(), 30u);
  EXPECT_EQ(job().speed_percent, 30u);
  EXPECT_FALSE(queue_.Take(SpeedView{"j1", kEpoch, 8, 9, ""})) << "below 10";
  EXPECT_FALSE(queue_.Take(SpeedView{"j1", kEpoch, 8, 101, ""})) << "above 100";
  EXPECT_FALSE(queue_.Take(SpeedView{"j1", kEpoch, 7, 50, ""})) << "seen";
  EXPECT_FALSE(queue_.Take(SpeedView{"j1", kEpoch - 1, 9, 50, ""})) << "stale";
  EXPECT_FALSE(queue_.Take(SpeedView{"j9", kEpoch, 9, 50, ""})) << "unknown";
  EXPECT_EQ(told(), 30u);
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE)) << "commands are counted apart";
  EXPECT_EQ(told(), 30u);
  EXPECT_TRUE(queue_.Take(SpeedView{"j1", kEpoch, 9, 10, ""}));
  EXPECT_EQ(told(), 10u);
}

TEST_F(JobQueueTest, PauseAndResume) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  EXPECT_FALSE(Granted());
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_EQ(job().message, "paused by ann@shop; resume it to go on");
  // The synchronizer hears of it later: its last words change nothing.
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 12, 100);
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, "", "no permission");
  EXPECT_EQ(job().message, "paused by ann@shop; resume it to go on");
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  EXPECT_FALSE(Granted()) << "the withdrawal has to be seen first";
  now_ += 400ms;
  EXPECT_TRUE(Granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 13, 100);
  EXPECT_EQ(job().state, intaglio_JOB_ENGRAVING);
}

TEST_F(JobQueueTest, AFaultWithdrawsThePermissionUntilResumed) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, "fault",
       "the door is open");
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_EQ(job().message, "the door is open");
  now_ += 5s;
  EXPECT_FALSE(Granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, "", "no permission");
  EXPECT_EQ(job().message, "the door is open");
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  EXPECT_TRUE(Granted());
  // Still about the old fault.
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, "fault",
       "the door is open");
  EXPECT_TRUE(Granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 13, 100);
  EXPECT_EQ(job().state, intaglio_JOB_ENGRAVING);
  now_ += 1s;
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 14, 100, "fault",
       "the stage is stuck");
  EXPECT_FALSE(Granted());
}

TEST_F(JobQueueTest, CancelRevokesEverything) {
  ReadyAll();
  Add(1);
  actions_.Orders();
  EXPECT_TRUE(Command(intaglio_COMMAND_CANCEL));
  EXPECT_EQ(job().state, intaglio_JOB_CANCELLED);
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("stop j1", "revoke d j1 1", "revoke s j1 1", "revoke y j1 1"));
  EXPECT_FALSE(Command(intaglio_COMMAND_ARM));
}

TEST_F(JobQueueTest, RestartTakesUpAQueuedAndABrokenChain) {
  ReadyAll();
  Add(1);
  Add(2);
  RecordingActions actions;
  JobQueue queue(actions);
  queue.Restore({actions_.kept.at("j1"), actions_.kept.at("j2")}, 1s, now_);
  EXPECT_EQ(queue.Find("j1")->state, intaglio_JOB_QUEUED);
  EXPECT_THAT(actions.Orders(),
              ElementsAre("revoke d j1 1", "revoke s j1 1", "revoke y j1 1"));
  now_ += 2s;
  for (const auto& [name, role] :
       std::map<std::string, intaglio_ServiceRole>{{"d", intaglio_ROLE_DISCRETIZER},
                                                   {"s", intaglio_ROLE_SORTER},
                                                   {"y", intaglio_ROLE_SYNCHRONIZER}}) {
    queue.Take(WorkerView{name, role, intaglio_HEALTH_READY, "c", ""}, now_);
  }
  queue.Turn(now_);
  EXPECT_EQ(queue.Find("j1")->attempt, 2u);
  EXPECT_EQ(queue.Find("j1")->lost_attempts, 0u);
  EXPECT_EQ(queue.Find("j2")->state, intaglio_JOB_QUEUED);
}

// It is armed for the block that was in the machine then.
TEST_F(JobQueueTest, TheArmOfAJobThatHasNotBegunStandsOverAShortRestartOnly) {
  Add(1);
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  ASSERT_TRUE(actions_.kept.at("j1").armed);
  for (const auto& [absence, stands] :
       {std::pair<std::optional<Nanoseconds>, bool>{2s, true},
        {31s, false},
        {std::nullopt, false}}) {
    for (const intaglio_JobState state :
         {intaglio_JOB_QUEUED, intaglio_JOB_DISCRETIZING, intaglio_JOB_SORTING}) {
      JobRecord kept = actions_.kept.at("j1");
      kept.state = state;
      RecordingActions actions;
      JobQueue queue(actions);
      queue.Restore({kept}, absence, now_);
      EXPECT_EQ(queue.Find("j1")->armed, stands) << state;
      kept.asks_before_resume = true;
      JobQueue asking(actions);
      asking.Restore({kept}, absence, now_);
      EXPECT_FALSE(asking.Find("j1")->armed) << state;
    }
  }
}

TEST_F(JobQueueTest, RestartPausesAnEngravingAndGoesOnWithTheSameSynchronizer) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  JobRecord kept = actions_.kept.at("j1");
  RecordingActions actions;
  JobQueue queue(actions);
  queue.Restore({kept}, std::nullopt, now_);
  EXPECT_EQ(queue.Find("j1")->state, intaglio_JOB_PAUSED);
  EXPECT_THAT(actions.Orders(), IsEmpty());
  now_ += 5s;
  queue.Turn(now_);
  EXPECT_FALSE(queue.Permissions(now_).at(0).granted);
  queue.Take(WorkerView{"y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY, "c", ""},
             now_);
  queue.Take(CommandView{"j1", kEpoch, 10, intaglio_COMMAND_RESUME, ""}, now_);
  EXPECT_TRUE(queue.Permissions(now_).at(0).granted);
}

TEST_F(JobQueueTest, AModelThatCannotBeSentFailsTheJob) {
  ReadyAll();
  Add(1);
  queue_.FeedFailed("j1", 7, "other attempt", now_);
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  queue_.FeedFailed("j1", 1, "cube.stl: cannot be read", now_);
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().message, "cube.stl: cannot be read");
}

TEST_F(JobQueueTest, RevisionsGrow) {
  ReadyAll();
  Add(1);
  const std::uint64_t before = job().revision;
  Task(intaglio_STAGE_DISCRETIZE, intaglio_TASK_RUNNING, 1, 10);
  EXPECT_EQ(job().revision, before + 1);
}

}  // namespace
}  // namespace intaglio::job_service
