// Commands that are sent at the same time, and armed jobs that lose their turn.

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::HasSubstr;

class JobDisarmTest : public JobQueueTest {
 protected:
  bool GrantedTo(const std::string& uid) {
    for (const PermissionView& permission : queue_.Permissions(now_)) {
      if (permission.granted && permission.job_uid == uid) return true;
    }
    return false;
  }
  /// What the workers of `uid` do until its whole path is in its synchronizer.
  void LoadPathOf(const std::string& uid) {
    const JobRecord& job = *queue_.Find(uid);
    for (std::uint32_t part = 0; part < job.parts.size(); ++part) {
      if (job.parts[part].worker.empty()) continue;
      TaskView done = StatusOf(job, intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE);
      done.task = job.TaskOf(intaglio_STAGE_DISCRETIZE, part);
      done.worker = job.parts[part].worker;
      Report(done);
    }
    Report(StatusOf(job, intaglio_STAGE_SORT, intaglio_TASK_DONE));
    TaskView loaded = StatusOf(job, intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING);
    loaded.done_count = 0;
    Report(loaded);
    ASSERT_EQ(job.state, intaglio_JOB_WAITING_FOR_ARM);
  }
  static TaskView StatusOf(const JobRecord& job, intaglio_Stage stage,
                           intaglio_TaskState state) {
    TaskView task;
    if (stage != intaglio_STAGE_DISCRETIZE) task.task = job.TaskOf(stage);
    task.stage = stage;
    task.worker = job.stage(stage).worker;
    task.state = state;
    task.done_count = task.total_count = 100;
    return task;
  }
  /// Those that had a task let go of it, and get what waits.
  void HandOutAgain() {
    ReadyAll();
    now_ += 2s;
    ReadyAll();
    queue_.Turn(now_);
  }
  /// To its end, armed by a person.
  void Finish(const std::string& uid) {
    LoadPathOf(uid);
    ASSERT_TRUE(Send(Order(intaglio_COMMAND_ARM, uid)).taken());
    now_ += 1s;
    ASSERT_TRUE(GrantedTo(uid));
    Report(StatusOf(*queue_.Find(uid), intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE));
    ASSERT_EQ(queue_.Find(uid)->state, intaglio_JOB_DONE);
  }
};

// A mill follows its first contour for minutes with nothing made yet, and to its end
// behind a pause: what is shown meanwhile is not that it waits for a block.
TEST_F(JobDisarmTest, AJobWhoseMachineIsAtWorkIsNotShownAsWaitingOrAtRest) {
  ReadyAll();
  Add(1, "c", 0, "marks");
  LoadPath();
  EXPECT_TRUE(Send(Order(intaglio_COMMAND_ARM)).taken());
  TaskView task = StatusOf(job(), intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING);
  task.done_count = 0;
  task.counts.armed = 1;
  Report(task);
  EXPECT_EQ(job().state, intaglio_JOB_ENGRAVING);
  EXPECT_TRUE(Send(Order(intaglio_COMMAND_PAUSE)).taken());
  EXPECT_THAT(job().at_work, HasSubstr("keep away"));
  task.message = "the machine is still at work";
  Report(task);
  EXPECT_EQ(job().state, intaglio_JOB_PAUSED);
  EXPECT_THAT(job().message, HasSubstr("paused by"));
  EXPECT_EQ(job().at_work, task.message);
  task.state = intaglio_TASK_PAUSED;
  task.counts.armed = 0;
  task.message = "waits for the permission of the job service";
  Report(task);
  EXPECT_EQ(job().at_work, "");
  EXPECT_THAT(job().message, HasSubstr("paused by"));
}

// Whichever is taken first, the job is not armed afterwards.
TEST_F(JobDisarmTest, PauseWinsOverAnArmThatWasSentAtTheSameTime) {
  ReadyAll();
  Add(1);
  LoadPath();
  for (const intaglio_JobCommandKind kind :
       {intaglio_COMMAND_ARM, intaglio_COMMAND_RESUME}) {
    for (const bool arm_first : {true, false}) {
      const CommandView arm = Order(kind);
      const CommandView pause = Order(intaglio_COMMAND_PAUSE);
      EXPECT_TRUE(!arm_first || Send(arm).taken());
      EXPECT_TRUE(Send(pause).taken());
      if (!arm_first) {
        const CommandAnswer answer = Send(arm);
        EXPECT_EQ(answer.code, intaglio_ANSWER_SUPERSEDED);
        EXPECT_THAT(answer.message, HasSubstr("paused by ann@shop"));
        EXPECT_THAT(answer.message, HasSubstr("intaglio arm 1"));
      }
      now_ += 1s;
      EXPECT_FALSE(Granted());
      EXPECT_FALSE(job().arm.armed());
    }
  }
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM)) << "by a person who knows of the pause";
  now_ += 1s;
  EXPECT_TRUE(Granted());
}

TEST_F(JobDisarmTest, AStopWinsOverAnArmThatWasSentBeforeItsReset) {
  ReadyAll();
  Add(1);
  LoadPath();
  const CommandView arm = Order(intaglio_COMMAND_ARM);
  queue_.SetStop("c", true, now_);
  queue_.SetStop("c", false, now_);
  EXPECT_EQ(Send(arm).code, intaglio_ANSWER_SUPERSEDED);
  now_ += 1s;
  EXPECT_FALSE(Granted());
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
}

TEST_F(JobDisarmTest, TheMessageOfAStopChangesWithItsReset) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  queue_.SetStop("c", true, now_);
  const auto message = [this] { return queue_.jobs().begin()->second.message; };
  EXPECT_EQ(message(), "the emergency stop of c was pressed");
  queue_.SetStop("c", false, now_);
  EXPECT_THAT(message(), testing::StartsWith("the emergency stop of c was pressed and is "
                                             "reset: check the machine, then "));
}

TEST_F(JobDisarmTest, AFaultWinsOverAResumeThatWasSentBeforeIt) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const CommandView resume = Order(intaglio_COMMAND_RESUME);
  now_ += 1s;
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_FAULT,
       "the door is open");
  const CommandAnswer answer = Send(resume);
  EXPECT_EQ(answer.code, intaglio_ANSWER_SUPERSEDED);
  EXPECT_THAT(answer.message, HasSubstr("the door is open"));
  now_ += 1s;
  EXPECT_FALSE(Granted());
}

// An arm makes a new grant, and a synchronizer starts on each once. A speed makes none:
// what a fault has spent, of which no status is here yet, stays spent.
TEST_F(JobDisarmTest, ASpeedIsNoNewGrant) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const std::uint64_t grant = queue_.Permissions(now_).at(0).grant;
  EXPECT_TRUE(Command(intaglio_COMMAND_SPEED));
  EXPECT_EQ(queue_.Permissions(now_).at(0).grant, grant);
}

// The answer of one was not kept, and it is delivered to the next life again.
TEST_F(JobDisarmTest, TheSameCommandIsAppliedOnceOverARestart) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  CommandView resume = Order(intaglio_COMMAND_RESUME);
  resume.fire_uncertain = true;
  EXPECT_TRUE(Send(resume).taken());
  RecordingActions actions;
  JobQueue queue(actions);
  queue.Restore({actions_.kept.at("j1")}, 1s, now_);
  const std::uint64_t grant = queue.Permissions(now_).at(0).grant;
  EXPECT_TRUE(queue.Receive(resume, now_).taken());
  EXPECT_EQ(queue.Permissions(now_).at(0).grant, grant);
}

// Armed for the block that is in the machine, which is then another job's.
TEST_F(JobDisarmTest, AnOvertakenJobIsNotArmed) {
  Add(1);
  EXPECT_FALSE(Command(intaglio_COMMAND_ARM)) << "its machine does not have it";
  Add(2, "c", 1);
  HandOutAgain();
  ASSERT_EQ(queue_.Find("j2")->state, intaglio_JOB_DISCRETIZING);
  Finish("j2");
  HandOutAgain();
  LoadPathOf("j1");
  now_ += 5s;
  EXPECT_FALSE(Granted());
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  EXPECT_TRUE(Granted());
}

TEST_F(JobDisarmTest, AJobThatIsHandedOutAgainAfterAHigherOneIsNotArmed) {
  ReadyAll();
  Add(1);
  LoadPath();
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  const CommandView late = Order(intaglio_COMMAND_ARM);
  Lose("y");  // before any permission: the attempt is over
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_FALSE(job().arm.armed());
  EXPECT_THAT(job().message, HasSubstr("it is no longer armed"));
  Add(2, "c", 1);
  HandOutAgain();
  Finish("j2");
  HandOutAgain();
  LoadPathOf("j1");
  now_ += 60s;
  EXPECT_FALSE(Granted());
  EXPECT_EQ(Send(late).code, intaglio_ANSWER_SUPERSEDED) << "of before it lost its turn";
  EXPECT_FALSE(Granted());
}

// A on machine c, B on machine e; the only sorter is lost in mid-job and then has B.
TEST_F(JobDisarmTest, OfTwoMachinesWithOneSorterTheOneThatWaitsIsNotArmed) {
  ReadyAll();
  queue_.Receive(
      WorkerView{"z", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "e", ""}, now_);
  Add(1);
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  Lose("s");
  EXPECT_FALSE(job().arm.armed());
  // A higher one on the other machine gets the sorter when it is back.
  Add(2, "e", 1);
  HandOutAgain();
  ASSERT_EQ(queue_.Find("j2")->state, intaglio_JOB_DISCRETIZING);
  EXPECT_EQ(Send(Order(intaglio_COMMAND_ARM)).code, intaglio_ANSWER_NOT_YET);
  Finish("j2");
  HandOutAgain();
  LoadPathOf("j1");
  now_ += 60s;
  EXPECT_FALSE(GrantedTo("j1"));
}

}  // namespace
}  // namespace intaglio::job_service
