// The parts of a job's discretizing: who gets them, and what becomes of them when
// discretizers are lost, fail, or come later.

#include <gmock/gmock.h>

#include "services/platform/host/stage/task_part.h"
#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class JobPartsTest : public JobQueueTest {
 protected:
  /// A job with two discretizers: sixteen parts, the first two at work.
  void BeginWithTwo() {
    ReadyAll();
    Ready("d2", intaglio_ROLE_DISCRETIZER);
    Add(1);
    actions_.Orders();
  }
  void Fail(std::uint32_t part, intaglio_ErrorCode code, const std::string& text) {
    TaskView report = PartReport(part, intaglio_TASK_FAILED, 0, 0);
    report.error_code = code;
    report.message = text;
    Report(report);
  }
  const StageRecord& stage() { return job().stage(intaglio_STAGE_DISCRETIZE); }
};

TEST_F(JobPartsTest, CountsOfParts) {
  EXPECT_EQ(PartCountFor(1), 1u);
  EXPECT_EQ(PartCountFor(2), 16u);
  EXPECT_EQ(PartCountFor(4), 32u);
  EXPECT_EQ(PartCountFor(100), 32u);
}

TEST_F(JobPartsTest, AllFreeDiscretizersBeginAndTakeTheNextOpenPart) {
  ReadyAll();
  Ready("d2", intaglio_ROLE_DISCRETIZER);
  Ready("d3", intaglio_ROLE_DISCRETIZER, intaglio_HEALTH_BUSY);
  Add(1);
  EXPECT_THAT(actions_.Orders(), ElementsAre("y j1 1", "s j1 1 > y", "d j1 1 0.0/16 > s",
                                             "d2 j1 1 1.0/16 > s"));
  Done(1);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d2 j1 1 2.0/16 > s"));
  Done(0);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 3.0/16 > s"));
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  DiscretizeAll();
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
  EXPECT_TRUE(stage().done);
  EXPECT_THAT(actions_.Orders(), testing::Contains("stop j1"));
}

TEST_F(JobPartsTest, OneThatComesLaterTakesPart) {
  BeginWithTwo();
  Ready("d3", intaglio_ROLE_DISCRETIZER);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d3 j1 1 2.0/16 > s"));
}

TEST_F(JobPartsTest, OneAloneHasTheWholeAndALaterOneNothing) {
  ReadyAll();
  Add(1);
  actions_.Orders();
  Ready("d2", intaglio_ROLE_DISCRETIZER);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), IsEmpty());
  Lose("d");
  EXPECT_THAT(actions_.Orders(), ElementsAre("revoke d j1 1", "d2 j1 1 > s"));
  EXPECT_EQ(job().parts.at(0).attempt, 1u);
  Done(0);
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
}

TEST_F(JobPartsTest, ALostDiscretizerCostsItsPartAlone) {
  BeginWithTwo();
  Lose("d");
  EXPECT_THAT(actions_.Orders(), ElementsAre("revoke d j1 1 0.0/16"));
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  EXPECT_EQ(job().attempt, 1u);
  EXPECT_EQ(job().message, "part 1 of 16 starts again: d was lost");
  Done(1);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d2 j1 1 0.1/16 > s"));
  DiscretizeAll();
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
  EXPECT_EQ(job().lost_attempts, 0u);
}

TEST_F(JobPartsTest, EitherMayBeLostAtAnyTime) {
  for (std::uint32_t done_before = 0; done_before < 16; ++done_before) {
    for (const char* lost : {"d", "d2"}) {
      RecordingActions actions;
      JobQueue queue(actions);
      const auto ready = [&](const char* name, intaglio_ServiceRole role) {
        queue.Receive(WorkerView{name, role, intaglio_HEALTH_READY, "c", ""}, now_);
      };
      ready("d", intaglio_ROLE_DISCRETIZER);
      ready("d2", intaglio_ROLE_DISCRETIZER);
      ready("s", intaglio_ROLE_SORTER);
      ready("y", intaglio_ROLE_SYNCHRONIZER);
      JobRecord record;
      record.number = 1;
      record.uid = "j1";
      record.cell = "c";
      queue.Add(record);
      queue.Turn(now_);
      const JobRecord& job = *queue.Find("j1");
      std::uint32_t done = 0;
      const auto finish_one = [&] {
        for (std::uint32_t i = 0; i < job.parts.size(); ++i) {
          if (job.parts[i].worker.empty() || job.parts[i].done) continue;
          TaskView report;
          report.task = job.TaskOf(intaglio_STAGE_DISCRETIZE, i);
          report.worker = job.parts[i].worker;
          report.state = intaglio_TASK_DONE;
          report.done_count = report.total_count = 10;
          queue.Receive(report, now_);
          queue.Turn(now_);
          ++done;
          return true;
        }
        return false;
      };
      while (done < done_before) ASSERT_TRUE(finish_one());
      queue.WorkerLost(lost, now_);
      queue.Turn(now_);
      while (finish_one()) {
      }
      EXPECT_EQ(done, 16u) << lost << " after " << done_before;
      EXPECT_EQ(job.state, intaglio_JOB_SORTING) << lost << " after " << done_before;
      EXPECT_EQ(job.attempt, 1u);
      EXPECT_EQ(job.stage(intaglio_STAGE_DISCRETIZE).done_count, 160u);
    }
  }
}

TEST_F(JobPartsTest, WithoutAnyItWaitsAndReportsItAndANewOneGoesOn) {
  BeginWithTwo();
  Done(0);
  Lose("d");
  Lose("d2");
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  EXPECT_EQ(
      job().message,
      "part 2 of 16 starts again: d2 was lost; waits for a discretizer (none runs)");
  for (const auto stage : {intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
    Task(stage, intaglio_TASK_ACCEPTED);
  }
  now_ += 600s;
  Ready("s", intaglio_ROLE_SORTER, intaglio_HEALTH_BUSY);
  Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
  queue_.Turn(now_);
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  actions_.Orders();
  Ready("d3", intaglio_ROLE_DISCRETIZER);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d3 j1 1 1.1/16 > s"));
  EXPECT_EQ(job().message, "part 2 of 16 starts again: d2 was lost");
  DiscretizeAll();
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
}

TEST_F(JobPartsTest, TheThirdLossOfOnePartFailsTheJobAndNamesIt) {
  BeginWithTwo();
  Lose("d2");
  Lose("d");
  for (const char* next : {"e1", "e2"}) {
    EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
    Ready(next, intaglio_ROLE_DISCRETIZER);
    queue_.Turn(now_);
    ASSERT_EQ(job().parts.at(0).worker, next);
    Lose(next);
  }
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().message, "part 1 of 16 has failed after 3 attempts; e2 was lost");
}

TEST_F(JobPartsTest, LossesOfDifferentPartsDoNotAddUp) {
  BeginWithTwo();
  for (int i = 0; i < 6; ++i) {
    Lose("d2");
    Done(0);  // of the first one, whose part it may be again
    Ready("d2", intaglio_ROLE_DISCRETIZER);
    now_ += 2s;
    Ready("d2", intaglio_ROLE_DISCRETIZER);
    queue_.Turn(now_);
    if (job().state != intaglio_JOB_DISCRETIZING) break;
    DiscretizeAll();
  }
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
}

TEST_F(JobPartsTest, AFailureOfTheJobItselfFailsItAtOnce) {
  BeginWithTwo();
  Fail(1, intaglio_ERROR_OUTSIDE_BLOCK, "12 points lie outside the block");
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().message, "12 points lie outside the block");
  EXPECT_THAT(actions_.Orders(), ElementsAre("stop j1", "revoke d j1 1 0.0/16",
                                             "revoke s j1 1", "revoke y j1 1"));
}

// The sorter that takes nothing may be dead: that is known after its lease at the latest.
TEST_F(JobPartsTest, AFailureForWantOfTheSorterIsTriedAgainAfterItsLease) {
  BeginWithTwo();
  Fail(0, intaglio_ERROR_LINK_LOST, "the consumer is gone");
  EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  EXPECT_EQ(job().message, "part 1 of 16 starts again: d: the consumer is gone");
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 2.0/16 > s")) << "another part";
  now_ += 1900ms;
  Done(2);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 3.0/16 > s"));
  now_ += 200ms;
  Done(3);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 0.1/16 > s"));
  Lose("s");
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_EQ(job().lost_attempts, 1u);
}

TEST_F(JobPartsTest, ASilentDiscretizerLosesItsPartAndIsUsedAgainWhenItHasDroppedIt) {
  BeginWithTwo();
  for (const std::uint32_t part : {0u, 1u})
    Report(PartReport(part, intaglio_TASK_ACCEPTED));
  for (const auto s : {intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
    Task(s, intaglio_TASK_ACCEPTED);
  }
  actions_.Orders();
  now_ += 11s;
  for (const auto& [name, role] :
       std::map<std::string, intaglio_ServiceRole>{{"d2", intaglio_ROLE_DISCRETIZER},
                                                   {"s", intaglio_ROLE_SORTER},
                                                   {"y", intaglio_ROLE_SYNCHRONIZER}}) {
    Ready(name, role, intaglio_HEALTH_BUSY);
  }
  const TaskView late = PartReport(0, intaglio_TASK_DONE);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("revoke d j1 1 2.0/16", "revoke d j1 1 0.0/16"));
  EXPECT_EQ(job().message, "part 1 of 16 starts again: d does not answer");
  // It was done all the same: it is ignored, but it is free again.
  Report(late);
  EXPECT_FALSE(job().parts.at(0).done);
  Ready("d", intaglio_ROLE_DISCRETIZER);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 0.1/16 > s"));
}

TEST_F(JobPartsTest, ProgressAddsUp) {
  BeginWithTwo();
  now_ += 3s;
  Report(PartReport(0, intaglio_TASK_RUNNING, 7, 14));
  Report(PartReport(1, intaglio_TASK_RUNNING, 1, 4));
  EXPECT_EQ(stage().done_count, 750u);
  EXPECT_EQ(stage().total_count, 16000u);
  EXPECT_EQ(stage().elapsed_s, 3.0);
  Report(PartReport(0, intaglio_TASK_DONE, 123, 123));
  EXPECT_EQ(stage().done_count, 1250u);
  Lose("d2");
  EXPECT_EQ(stage().done_count, 1000u);
  Ready("d2", intaglio_ROLE_DISCRETIZER);
  DiscretizeAll();
  DiscretizeAll();
  EXPECT_EQ(stage().done_count, 1623u) << "points, when all are made";
  EXPECT_EQ(stage().total_count, 1623u);
}

TEST_F(JobPartsTest, AFreeOneServesTheJobUnderWayBeforeTheNext) {
  BeginWithTwo();
  queue_.Receive(
      WorkerView{"z", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "e", ""}, now_);
  Ready("s2", intaglio_ROLE_SORTER);
  Add(2, "e");
  EXPECT_EQ(queue_.Find("j2")->state, intaglio_JOB_QUEUED);
  for (std::uint32_t part = 0; part < 14; ++part) Done(part);
  EXPECT_EQ(queue_.Find("j2")->state, intaglio_JOB_QUEUED);
  actions_.Orders();
  Done(14);
  EXPECT_EQ(queue_.Find("j2")->state, intaglio_JOB_DISCRETIZING)
      << "the last part is at work; the other discretizer is free";
  EXPECT_EQ(queue_.Find("j2")->parts.size(), 1u);
  Done(15);
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
}

// The sorter has all points, and the report of a part, with its warnings, is on its way.
TEST_F(JobPartsTest, WhenTheSorterHasAllEveryPartIsStillReported) {
  BeginWithTwo();
  for (std::uint32_t part = 0; part < 15; ++part) Done(part);
  actions_.Orders();
  Task(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100, 100);
  EXPECT_THAT(actions_.Orders(), testing::IsEmpty());
  EXPECT_FALSE(stage().done);
  Done(15);
  EXPECT_THAT(actions_.Orders(), ElementsAre("stop j1"));
  EXPECT_TRUE(stage().done);
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
}

TEST_F(JobPartsTest, AReportThatIsLostBehindThePathIsMadeAnewWithoutAConsumer) {
  BeginWithTwo();
  for (std::uint32_t part = 0; part < 15; ++part) Done(part);
  Task(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100, 100);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, {}, "waits for the arm");
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_EQ(job().message, "waits for the report about part 16 of 16");
  const std::string lost = job().parts.at(15).worker;
  const std::string other = lost == "d" ? "d2" : "d";
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  actions_.Orders();
  Ready(other, intaglio_ROLE_DISCRETIZER);
  Lose(lost);
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("revoke " + lost + " j1 1 15.0/16", other + " j1 1 15.1/16"));
  now_ += 5s;
  EXPECT_FALSE(Granted());
  Done(15);
  EXPECT_EQ(job().message, "") << "until the machine's next report";
  now_ += 1s;
  EXPECT_TRUE(Granted());
}

TEST_F(JobPartsTest, ALostSorterTakesAllPartsWithItAndTheyBeginAnew) {
  BeginWithTwo();
  Done(0);
  actions_.Orders();
  Lose("s");
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("stop j1", "revoke d2 j1 1 1.0/16", "revoke d j1 1 2.0/16",
                          "revoke s j1 1", "revoke y j1 1"));
  now_ += 2s;
  ReadyAll();
  Ready("d2", intaglio_ROLE_DISCRETIZER);
  queue_.Turn(now_);
  EXPECT_EQ(job().attempt, 2u);
  EXPECT_THAT(actions_.Orders(), ElementsAre("y j1 2", "s j1 2 > y", "d j1 2 0.0/16 > s",
                                             "d2 j1 2 1.0/16 > s"));
}

TEST_F(JobPartsTest, ARestartRevokesEveryPart) {
  BeginWithTwo();
  RecordingActions actions;
  JobQueue queue(actions);
  queue.Restore({actions_.kept.at("j1")}, std::nullopt, now_);
  EXPECT_THAT(actions.Orders(),
              ElementsAre("revoke d j1 1 0.0/16", "revoke d2 j1 1 1.0/16",
                          "revoke s j1 1", "revoke y j1 1"));
  EXPECT_EQ(queue.Find("j1")->state, intaglio_JOB_QUEUED);
}

}  // namespace
}  // namespace intaglio::job_service
