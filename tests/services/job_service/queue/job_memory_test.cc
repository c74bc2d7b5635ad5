// What a queue that works for years keeps in memory.

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::ElementsAre;

class JobMemoryTest : public JobQueueTest {
 protected:
  void Cancel(std::uint32_t number) {
    CommandView cancel;
    cancel.sender = "ann's client";
    cancel.job_uid = fmt::format("j{}", number);
    cancel.epoch = kEpoch;
    cancel.number = number;
    cancel.kind = intaglio_COMMAND_CANCEL;
    cancel.operator_name = "ann@shop";
    EXPECT_TRUE(queue_.Receive(cancel, now_).taken());
    queue_.Turn(now_);
  }
  void AddAndCancel(std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t number = from; number <= to; ++number) {
      Add(number);
      Cancel(number);
    }
  }
  static constexpr auto kRemembered = static_cast<std::uint32_t>(kRememberedJobs);
};

TEST_F(JobMemoryTest, AnEndStaysForAWhileWhateverEndsAfterIt) {
  AddAndCancel(1, kRemembered + 2);
  EXPECT_EQ(queue_.jobs().size(), kRememberedJobs + 2);
  now_ += kRememberedFor - 1ns;
  queue_.Turn(now_);
  EXPECT_THAT(actions_.forgotten, ElementsAre());
  now_ += 1ns;
  queue_.Turn(now_);
  EXPECT_THAT(actions_.forgotten, ElementsAre("j1", "j2"));
  EXPECT_EQ(queue_.Find("j2"), nullptr);
  ASSERT_NE(queue_.Find("j3"), nullptr);
  EXPECT_EQ(queue_.Find("j3")->state, intaglio_JOB_CANCELLED);
}

TEST_F(JobMemoryTest, TheNewestEndsStayForEver) {
  AddAndCancel(1, kRemembered);
  now_ += 24h * 365;
  queue_.Turn(now_);
  EXPECT_THAT(actions_.forgotten, ElementsAre());
  EXPECT_EQ(queue_.jobs().size(), kRememberedJobs);
}

TEST_F(JobMemoryTest, AnOpenJobIsNeverForgotten) {
  Add(1);
  AddAndCancel(2, kRemembered + 2);
  now_ += 24h;
  queue_.Turn(now_);
  EXPECT_THAT(actions_.forgotten, ElementsAre("j2"));
  ASSERT_NE(queue_.Find("j1"), nullptr);
  EXPECT_EQ(queue_.Find("j1")->state, intaglio_JOB_QUEUED);
}

TEST_F(JobMemoryTest, YearsOfJobsTakeNoMoreThanTheNewest) {
  ReadyAll();
  for (std::uint32_t number = 1; number <= 5'000; ++number) {
    AddAndCancel(number, number);
    now_ += 10s;
  }
  EXPECT_LE(queue_.jobs().size(), kRememberedJobs + 6);
  EXPECT_EQ(actions_.forgotten.size() + queue_.jobs().size(), 5'000u);
}

TEST_F(JobMemoryTest, AnEndedJobKeepsNoFrozenJob) {
  JobRecord job;
  job.number = 1;
  job.uid = "j1";
  job.epoch = kEpoch;
  job.cell = "c";
  job.frozen_job = std::string(1000, 'x');
  queue_.Add(job);
  Cancel(1);
  EXPECT_EQ(actions_.kept.at("j1").frozen_job.size(), 1000u)
      << "kept before it is dropped";
  EXPECT_EQ(queue_.Find("j1")->frozen_job.size(), 0u);
}

TEST_F(JobMemoryTest, RestoredEndsLeaveInTheirTurn) {
  std::vector<JobRecord> jobs(kRememberedJobs);
  for (std::uint32_t i = 0; i < kRemembered; ++i) {
    jobs[i].number = i + 1;
    jobs[i].uid = fmt::format("j{}", i + 1);
    jobs[i].state = intaglio_JOB_DONE;
  }
  queue_.Restore(jobs, std::nullopt, now_);
  AddAndCancel(kRemembered + 1, kRemembered + 1);
  now_ += kRememberedFor;
  queue_.Turn(now_);
  EXPECT_THAT(actions_.forgotten, ElementsAre("j1"));
}

// A discretizer that dies as soon as it is there, over and over.
TEST_F(JobMemoryTest, WorkersThatAreLongGoneAreForgotten) {
  for (int i = 0; i < 10'000; ++i) {
    const std::string name = fmt::format("d{}", i);
    Ready(name, intaglio_ROLE_DISCRETIZER);
    Lose(name);
    now_ += 10s;
  }
  // Those of an hour, 360.
  EXPECT_EQ(actions_.forgotten.size(), 10'000u - 360);
  EXPECT_EQ(actions_.forgotten.front(), "d0");
}

TEST_F(JobMemoryTest, AWorkerThatCameBackIsNotForgotten) {
  Ready("slow", intaglio_ROLE_DISCRETIZER);
  Lose("slow");
  Ready("slow", intaglio_ROLE_DISCRETIZER);
  for (int i = 0; i < 100; ++i) {
    Ready(fmt::format("d{}", i), intaglio_ROLE_DISCRETIZER);
    Lose(fmt::format("d{}", i));
  }
  now_ += WorkerBook::kLostStaysFor;
  queue_.Turn(now_);
  EXPECT_EQ(actions_.forgotten.size(), 100 - WorkerBook::kLostKept);
  EXPECT_THAT(actions_.forgotten, testing::Not(testing::Contains("slow")));
}

// The synchronizer of a cancelled job may report when the queue has forgotten the job:
// then it is free again, and nothing else follows.
TEST_F(JobMemoryTest, ALateReportOnAForgottenJobFreesItsWorker) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const TaskId engraving = job().TaskOf(intaglio_STAGE_ENGRAVE);
  ASSERT_TRUE(Command(intaglio_COMMAND_CANCEL));
  AddAndCancel(2, kRemembered + 1);
  now_ += kRememberedFor;
  queue_.Turn(now_);
  ASSERT_EQ(queue_.Find("j1"), nullptr);
  TaskView late;
  late.task = engraving;
  late.stage = intaglio_STAGE_ENGRAVE;
  late.worker = "y";
  late.state = intaglio_TASK_FAILED;
  late.error_code = intaglio_ERROR_CANCELLED;
  queue_.Receive(late, now_);
  ReadyAll();
  actions_.Orders();
  Add(kRemembered + 2);
  EXPECT_THAT(actions_.Orders(), testing::Contains(testing::HasSubstr("y j102 1")));
}

}  // namespace
}  // namespace intaglio::job_service
