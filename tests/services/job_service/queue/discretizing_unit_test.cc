// Discretizing alone; with the rest of the queue: discretizing_test.cc.

#include "services/job_service/queue/discretizing.h"
#include "services/platform/host/stage/task_part.h"
#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using Outcome = Discretizing::Outcome;

class DiscretizingUnitTest : public testing::Test {
 protected:
  DiscretizingUnitTest() {
    JobRecord job;
    job.uid = "j1";
    job.attempt = 1;
    job.state = intaglio_JOB_DISCRETIZING;
    job.stage(intaglio_STAGE_SORT).worker = "s";
    job_ = &book_.Add(job);
    actions_.kept["j1"] = *job_;
    Discretizing::Cut(*job_, {"a", "b"}, now_);
    for (const char* name : {"a", "b"}) {
      tasks_.workers().Update(
          {name, intaglio_ROLE_DISCRETIZER, intaglio_HEALTH_READY, "", ""}, now_);
    }
    discretizing_.GiveFirst(*job_, now_);
  }
  TaskView Report(std::uint32_t part, intaglio_TaskState state) {
    TaskView task;
    task.task = job_->TaskOf(intaglio_STAGE_DISCRETIZE, part);
    task.worker = job_->parts[part].worker;
    task.state = state;
    task.done_count = task.total_count = 5;
    return task;
  }
  Outcome Receive(std::uint32_t part, intaglio_TaskState state) {
    return discretizing_.Receive(*job_, Report(part, state), now_);
  }
  bool Lose(std::uint32_t part) {
    return discretizing_.Lose(*job_, part, "a was lost", 2s, now_).has_value();
  }

  Nanoseconds now_{100s};
  RecordingActions actions_;
  JobBook book_{actions_};
  TaskHandout tasks_{actions_};
  Discretizing discretizing_{book_, tasks_};
  JobRecord* job_ = nullptr;
};

TEST_F(DiscretizingUnitTest, ReportsOnlyWhatFollows) {
  EXPECT_EQ(Receive(0, intaglio_TASK_RUNNING), Outcome::kProgress);
  EXPECT_EQ(Receive(0, intaglio_TASK_FAILED), Outcome::kFailed);
  EXPECT_EQ(Receive(1, intaglio_TASK_DONE), Outcome::kProgress);
  EXPECT_EQ(Receive(1, intaglio_TASK_DONE), Outcome::kIgnored) << "it is done";
  TaskView other = Report(0, intaglio_TASK_DONE);
  other.worker = "b";
  EXPECT_EQ(discretizing_.Receive(*job_, other, now_), Outcome::kIgnored);
  for (std::uint32_t part = 2; part < 16; ++part) {
    job_->parts.Give(part, "b");
    EXPECT_EQ(Receive(part, intaglio_TASK_DONE), Outcome::kProgress);
  }
  EXPECT_EQ(Receive(0, intaglio_TASK_DONE), Outcome::kAllDone);
  EXPECT_EQ(job_->stage(intaglio_STAGE_DISCRETIZE).done_count, 16u * 5u);
}

TEST_F(DiscretizingUnitTest, APartThatIsLostTooOftenGivesTheJobUp) {
  actions_.Orders();
  for (std::uint32_t loss = 1; loss < host::kMaxPartLosses; ++loss) {
    EXPECT_FALSE(Lose(0));
    EXPECT_EQ(job_->parts[0].losses, loss);
    EXPECT_EQ(job_->parts.NextOpen(now_), 2u) << "it waits for 2 s";
    now_ += 2s;
    job_->parts.Give(0, "a");
    tasks_.GivePart(*job_, 0, now_);
  }
  EXPECT_TRUE(Lose(0));
  EXPECT_EQ(std::ranges::count(actions_.Orders(), "revoke a j1 1 0.0/16"), 1)
      << "every attempt once";
}

TEST_F(DiscretizingUnitTest, WhoHasAcceptedAPartGetsOneAhead) {
  actions_.Orders();
  discretizing_.GiveOpen(*job_, now_);
  EXPECT_THAT(actions_.Orders(), testing::IsEmpty());
  tasks_.workers().Answered("a", job_->TaskOf(intaglio_STAGE_DISCRETIZE, 0));
  discretizing_.GiveOpen(*job_, now_);
  EXPECT_THAT(actions_.Orders(), testing::ElementsAre("a j1 1 2.0/16 > s"));
  const TaskId ahead = job_->TaskOf(intaglio_STAGE_DISCRETIZE, 2);
  discretizing_.LoseAhead("b", ahead);
  EXPECT_EQ(job_->parts[2].attempt, 0u) << "b does not have it";
  discretizing_.LoseAhead("a", ahead);
  EXPECT_EQ(job_->parts[2].attempt, 1u);
  EXPECT_THAT(actions_.Orders(), testing::ElementsAre("revoke a j1 1 2.0/16"));
}

TEST_F(DiscretizingUnitTest, APartThatIsLostBehindThePathIsMadeForItsReportAlone) {
  job_->stage(intaglio_STAGE_SORT).done = true;
  EXPECT_FALSE(Lose(0));
  actions_.Orders();
  now_ += 2s;
  job_->parts.Give(0, "a");
  tasks_.GivePart(*job_, 0, now_);
  EXPECT_THAT(actions_.Orders(), testing::ElementsAre("a j1 1 0.1/16"))
      << "without a consumer: nobody takes points any more";
}

}  // namespace
}  // namespace intaglio::job_service
