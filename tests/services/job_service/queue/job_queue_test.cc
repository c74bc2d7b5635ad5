#include "services/job_service/queue/job_queue.h"

#include "tests/services/job_service/queue/queue_bench.h"

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
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, {}, "waits for the arm");
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_EQ(job().message, "waits for the arm");
  EXPECT_EQ(job().estimate_ticks, 77u);
  EXPECT_FALSE(Granted());
  Engrave();
  EXPECT_TRUE(actions_.kept.at("j1").arm.ever_granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100, 100);
  EXPECT_EQ(job().state, intaglio_JOB_DONE);
  EXPECT_FALSE(Granted());
  EXPECT_THAT(actions_.Orders(), ElementsAre("stop j1", "stop j1"))
      << "when the points are made, and at the end";
}

// It is the sorter's while it works, the synchronizer's when the motion is planned.
TEST_F(JobQueueTest, TheFirstEstimateIsKeptWhenTheMotionIsPlanned) {
  ReadyAll();
  Add(1);
  Task(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100, 100);
  EXPECT_EQ(job().estimate_ticks, 0u);
  TaskView sorting = SortStatus(1, intaglio_TASK_RUNNING);
  sorting.estimate_ticks = 90;
  Report(sorting);
  EXPECT_EQ(job().first_estimate_ticks, 90u);
  EXPECT_EQ(job().estimate_ticks, 90u) << "what people see until there is a plan";
  sorting.estimate_ticks = 95;
  sorting.state = intaglio_TASK_DONE;
  Report(sorting);
  EXPECT_EQ(job().first_estimate_ticks, 90u) << "the first stays";
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100);
  EXPECT_EQ(job().estimate_ticks, 77u);
  EXPECT_EQ(job().first_estimate_ticks, 90u);
}

TEST_F(JobQueueTest, AJobOfMarksWaitsForAMarker) {
  Add(1, "c", 0, "marks");
  EXPECT_THAT(job().message,
              HasSubstr("waits for a marker of c (one that runs reports within 2 s)"));
}

TEST_F(JobQueueTest, WaitsForWorkersAndReportsWhich) {
  Add(1);
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  // The services of a machine are heard from its first job on.
  EXPECT_THAT(job().message,
              HasSubstr("a synchronizer of c (one that runs reports within 2 s)"));
  now_ += 2s;
  queue_.Turn(now_);
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
      queue_.Receive(Order(intaglio_COMMAND_CANCEL, uid), now_);
      break;
    }
    ReadyAll();
    now_ += 2s;
    ReadyAll();
    queue_.Turn(now_);
    EXPECT_EQ(queue_.Find(next)->state, intaglio_JOB_DISCRETIZING) << next;
  }
}

TEST_F(JobQueueTest, AJobThatItsMachineDoesNotHaveCannotBeArmed) {
  Add(1);
  Add(2);
  CommandAnswer answer = Send(Order(intaglio_COMMAND_ARM));
  EXPECT_EQ(answer.code, intaglio_ANSWER_NOT_YET) << "it waits for workers";
  EXPECT_THAT(
      answer.message,
      HasSubstr("waits for a synchronizer of c (one that runs reports within 2 s)"));
  EXPECT_THAT(answer.message, HasSubstr("intaglio arm 1"));
  EXPECT_FALSE(job().arm.armed());
  ReadyAll();
  queue_.Turn(now_);
  answer = Send(Order(intaglio_COMMAND_ARM, "j2"));
  EXPECT_EQ(answer.code, intaglio_ANSWER_NOT_YET);
  EXPECT_FALSE(queue_.Find("j2")->arm.armed());
  EXPECT_THAT(answer.message, HasSubstr("waits for its turn on c"));
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  EXPECT_TRUE(job().arm.armed());
}

TEST_F(JobQueueTest, AnotherCellGoesOnMeanwhile) {
  ReadyAll();
  Ready("s2", intaglio_ROLE_SORTER);
  queue_.Receive(
      WorkerView{"z", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "e", ""}, now_);
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
  EXPECT_THAT(job().message, HasSubstr("attempt 1 failed: s was lost; waits for"));
  // The discretizer reports that it has dropped the old attempt; the synchronizer never
  // got it.
  TaskView dropped = SortStatus(1, intaglio_TASK_FAILED);
  dropped.stage = intaglio_STAGE_DISCRETIZE;
  dropped.worker = "d";
  queue_.Receive(dropped, now_);
  now_ += 500ms;
  ReadyAll();
  queue_.Turn(now_);
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED) << "the synchronizer may still be at it";
  now_ += 600ms;
  Ready("y", intaglio_ROLE_SYNCHRONIZER);
  Lose("s");  // came back in ReadyAll; gone for good now
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("y j1 2", "s2 j1 2 > y", "d j1 2 > s2"));
  EXPECT_THAT(job().message, HasSubstr("attempt 2: attempt 1 failed: s was lost"));
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
  queue_.Receive(dropped, now_);
  Ready("y", intaglio_ROLE_SYNCHRONIZER);
  queue_.Turn(now_);
  EXPECT_EQ(job().attempt, 2u);
  EXPECT_EQ(job().stage(intaglio_STAGE_ENGRAVE).worker, "y");
}

TEST_F(JobQueueTest, OldAttemptsAreIgnored) {
  ReadyAll();
  Ready("y2", intaglio_ROLE_SYNCHRONIZER);
  Add(1);
  Lose("y");
  const TaskView late = SortStatus(1, intaglio_TASK_DONE);
  queue_.Receive(late, now_);
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_FALSE(job().stage(intaglio_STAGE_SORT).done);
  now_ += 2s;
  Ready("d", intaglio_ROLE_DISCRETIZER);
  Ready("s", intaglio_ROLE_SORTER);
  queue_.Turn(now_);
  ASSERT_EQ(job().attempt, 2u);
  queue_.Receive(late, now_);
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
              HasSubstr("failed after 3 attempts; attempt 3 failed: s was lost"));
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
  Task(intaglio_STAGE_DISCRETIZE, intaglio_TASK_FAILED, 0, 0, intaglio_ERROR_UNREADABLE,
       "cube.stl is empty");
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().message, "cube.stl is empty");
}

TEST_F(JobQueueTest, AFailureThatANeighboursDeathCausesIsTriedAgain) {
  ReadyAll();
  Add(1);
  Task(intaglio_STAGE_SORT, intaglio_TASK_FAILED, 0, 0, intaglio_ERROR_LINK_LOST,
       "no points come");
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
  CommandView stale = Order(intaglio_COMMAND_ARM);
  --stale.epoch;
  EXPECT_EQ(Send(stale).code, intaglio_ANSWER_WRONG_EPOCH);
  EXPECT_EQ(Send(Order(intaglio_COMMAND_ARM, "j9")).code, intaglio_ANSWER_UNKNOWN_JOB);
  CommandView odd = Order(intaglio_COMMAND_ARM);
  odd.kind = static_cast<intaglio_JobCommandKind>(77);
  EXPECT_EQ(Send(odd).code, intaglio_ANSWER_OUT_OF_RANGE);
  now_ += 1s;
  EXPECT_FALSE(Granted());
  EXPECT_EQ(actions_.kept.at("j1").arm.kept().last_command, 0u);
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

TEST_F(JobQueueTest, TakesASpeedWithinItsRangeAndSendsItToTheCell) {
  ReadyAll();
  Add(1);
  LoadPath();
  const auto speed_percent = [this] {
    return queue_.Permissions(now_).at(0).speed_percent;
  };
  const auto speed = [this](std::uint32_t percent) {
    CommandView command = Order(intaglio_COMMAND_SPEED);
    command.speed_percent = percent;
    return Send(command);
  };
  EXPECT_EQ(speed_percent(), 100u);
  EXPECT_TRUE(speed(30).taken());
  EXPECT_EQ(speed_percent(), 30u);
  EXPECT_EQ(job().speed_percent, 30u);
  EXPECT_EQ(speed(0).code, intaglio_ANSWER_OUT_OF_RANGE);
  EXPECT_THAT(speed(141).message, HasSubstr("141 of job 1 is outside 1..140"));
  EXPECT_EQ(speed_percent(), 30u);
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  EXPECT_EQ(speed_percent(), 30u);
  EXPECT_TRUE(speed(1).taken());
  EXPECT_EQ(speed_percent(), 1u);
  EXPECT_TRUE(speed(140).taken());
  EXPECT_EQ(speed_percent(), 140u);
}

TEST_F(JobQueueTest, PauseAndResume) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  EXPECT_FALSE(Granted());
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_EQ(job().message, "paused by ann@shop; resume it to continue");
  // The synchronizer receives it later: its last reports change nothing.
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 12, 100);
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_NOT_ARMED,
       "no permission");
  EXPECT_EQ(job().message, "paused by ann@shop; resume it to continue");
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
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_FAULT,
       "the door is open");
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_EQ(job().message, "the door is open");
  now_ += 5s;
  EXPECT_FALSE(Granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_NOT_ARMED,
       "no permission");
  EXPECT_EQ(job().message, "the door is open");
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  EXPECT_TRUE(Granted());
  // Still about the old fault.
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_FAULT,
       "the door is open");
  EXPECT_TRUE(Granted());
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 13, 100);
  EXPECT_EQ(job().state, intaglio_JOB_ENGRAVING);
  now_ += 1s;
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 14, 100, intaglio_PAUSE_FAULT,
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
  EXPECT_EQ(Send(Order(intaglio_COMMAND_ARM)).code, intaglio_ANSWER_ENDED_JOB);
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
    queue.Receive(WorkerView{name, role, intaglio_HEALTH_READY, "c", ""}, now_);
  }
  queue.Turn(now_);
  EXPECT_EQ(queue.Find("j1")->attempt, 2u);
  EXPECT_EQ(queue.Find("j1")->lost_attempts, 0u);
  EXPECT_EQ(queue.Find("j2")->state, intaglio_JOB_QUEUED);
}

// It is armed for the block that was in the machine then, and it may lose its turn.
TEST_F(JobQueueTest, ARestartDisarmsAJobThatHasNotBegunToFire) {
  ReadyAll();
  Add(1);
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  ASSERT_TRUE(actions_.kept.at("j1").arm.armed());
  for (const std::optional<Nanoseconds> absence :
       {std::optional<Nanoseconds>(2s), std::optional<Nanoseconds>(31s),
        std::optional<Nanoseconds>()}) {
    for (const intaglio_JobState state :
         {intaglio_JOB_QUEUED, intaglio_JOB_DISCRETIZING, intaglio_JOB_SORTING,
          intaglio_JOB_WAITING_FOR_ARM}) {
      JobRecord kept = actions_.kept.at("j1");
      kept.state = state;
      RecordingActions actions;
      JobQueue queue(actions);
      queue.Restore({kept}, absence, now_);
      EXPECT_EQ(queue.Find("j1")->state, intaglio_JOB_QUEUED);
      EXPECT_FALSE(queue.Find("j1")->arm.armed()) << state;
      if (state == intaglio_JOB_QUEUED) continue;
      EXPECT_GT(queue.Find("j1")->arm.disarm_count(), kept.arm.disarm_count());
      EXPECT_THAT(queue.Find("j1")->message, HasSubstr("it is no longer armed"));
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
  queue.Receive(
      WorkerView{"y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY, "c", ""}, now_);
  CommandView resume = Order(intaglio_COMMAND_RESUME);
  EXPECT_EQ(queue.Receive(resume, now_).code, intaglio_ANSWER_SUPERSEDED)
      << "sent before the restart";
  ++resume.number;
  resume.disarm_count = queue.Find("j1")->arm.disarm_count();
  EXPECT_TRUE(queue.Receive(resume, now_).taken());
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
