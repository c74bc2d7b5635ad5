#include "services/job_service/queue/task_handout.h"

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::ElementsAre;

class TaskHandoutTest : public testing::Test {
 protected:
  TaskHandoutTest() {
    job_.uid = "j1";
    job_.attempt = 1;
    job_.state = intaglio_JOB_DISCRETIZING;
    job_.parts.Cut(2, now_);
    job_.stage(intaglio_STAGE_SORT).worker = "s";
    job_.stage(intaglio_STAGE_ENGRAVE).worker = "y";
    actions_.kept["j1"] = job_;
  }
  TaskId Part(std::uint32_t part) { return job_.TaskOf(intaglio_STAGE_DISCRETIZE, part); }

  Nanoseconds now_{100s};
  JobRecord job_;
  RecordingActions actions_;
  TaskHandout tasks_{actions_};
};

TEST_F(TaskHandoutTest, WhatIsGivenIsInTheBook) {
  tasks_.Give(job_, intaglio_STAGE_SORT, "s", "y", now_);
  EXPECT_TRUE(tasks_.workers().IsAssigned("s", job_.TaskOf(intaglio_STAGE_SORT)));
  job_.parts.Give(0, "a");
  tasks_.GivePart(job_, 0, now_);
  job_.parts.Give(1, "a");
  tasks_.GivePartAhead(job_, 1, now_);
  EXPECT_TRUE(tasks_.workers().IsAssigned("a", Part(0)));
  EXPECT_TRUE(tasks_.workers().IsAssigned("a", Part(1)));
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("s j1 1 > y", "a j1 1 0.0/16 > s", "a j1 1 1.0/16 > s"));
}

TEST_F(TaskHandoutTest, OnlyWhatAWorkerStillHasIsRevokedAndOnce) {
  tasks_.Give(job_, intaglio_STAGE_SORT, "s", "y", now_);
  tasks_.Give(job_, intaglio_STAGE_ENGRAVE, "y", {}, now_);
  tasks_.workers().Release("s", job_.TaskOf(intaglio_STAGE_SORT), now_);
  actions_.Orders();
  tasks_.RevokeAndStopFeed(job_, job_.GivenTasks(), now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("stop j1", "revoke y j1 1"));
  tasks_.RevokeHeld(job_, job_.GivenTasks(), now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre());
}

// Its lamp stays on.
TEST_F(TaskHandoutTest, TheRevocationOfAnEngravingReportsWhetherItGoesOn) {
  struct Orders : RecordingActions {
    void Give(const TaskOrder& order, const JobRecord&) override {
      take_up.push_back(order.take_up);
    }
    std::vector<bool> take_up;
  } orders;
  TaskHandout tasks(orders);
  const auto revoke = [&](intaglio_Stage stage) {
    tasks.Revoke(job_, {"y", stage, job_.TaskOf(stage), false}, now_);
  };
  revoke(intaglio_STAGE_ENGRAVE);
  job_.arm.NoteGranted();
  revoke(intaglio_STAGE_ENGRAVE);
  revoke(intaglio_STAGE_SORT);
  job_.state = intaglio_JOB_CANCELLED;
  revoke(intaglio_STAGE_ENGRAVE);
  EXPECT_THAT(orders.take_up, ElementsAre(false, true, false, false));
}

TEST_F(TaskHandoutTest, AJobThatIsTakenUpNamesNoConsumer) {
  tasks_.GiveTakeUp(job_, now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("take up y j1 1"));
  EXPECT_TRUE(tasks_.workers().IsAssigned("y", job_.TaskOf(intaglio_STAGE_ENGRAVE)));
}

}  // namespace
}  // namespace intaglio::job_service
