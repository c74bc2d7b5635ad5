// The parts that discretizers get ahead, before they have ended what they are at.

#include <gmock/gmock.h>

#include <deque>
#include <random>

#include "services/platform/host/stage/task_part.h"
#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class PartsAheadTest : public JobQueueTest {
 protected:
  /// A job with two discretizers: sixteen parts, the first two given.
  void BeginWithTwo() {
    ReadyAll();
    Ready("d2", intaglio_ROLE_DISCRETIZER);
    Add(1);
    actions_.Orders();
  }
  void Accept(std::uint32_t part) {
    Report(PartReport(part, intaglio_TASK_ACCEPTED, 0, 0));
  }
  void Fail(std::uint32_t part, intaglio_ErrorCode code) {
    TaskView report = PartReport(part, intaglio_TASK_FAILED, 0, 0);
    report.error_code = code;
    Report(report);
  }
  const PartRecord& part(std::size_t index) { return job().parts.at(index); }
};

TEST_F(PartsAheadTest, WhoHasAcceptedAPartGetsTheNextOne) {
  BeginWithTwo();
  Accept(0);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 2.0/16 > s"));
  Accept(0);
  EXPECT_THAT(actions_.Orders(), IsEmpty()) << "one at a time";
  Accept(1);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d2 j1 1 3.0/16 > s"));
  Accept(2);
  EXPECT_THAT(actions_.Orders(), IsEmpty());
  Done(0);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 4.0/16 > s"));
}

// Only the newest of a worker's tasks is retained: two on their way could become one.
TEST_F(PartsAheadTest, NoOtherUntilTheOneGivenAheadIsAccepted) {
  BeginWithTwo();
  Accept(0);
  Done(0);
  actions_.Orders();
  Report(PartReport(2, intaglio_TASK_RUNNING, 1, 3));
  EXPECT_THAT(actions_.Orders(), ElementsAre("d j1 1 3.0/16 > s"));
}

TEST_F(PartsAheadTest, ASingleDiscretizerHasTheWholeAndNothingAhead) {
  ReadyAll();
  Add(1);
  actions_.Orders();
  Accept(0);
  EXPECT_THAT(actions_.Orders(), IsEmpty());
}

// The last parts wait for the first free discretizer.
TEST_F(PartsAheadTest, TowardsTheEndNothingIsGivenAhead) {
  BeginWithTwo();
  for (std::uint32_t index = 0; index < 14; ++index) {
    ASSERT_FALSE(part(index).worker.empty()) << index;
    Accept(index);
    Accept(1 - index % 2 + index - index % 2);
    if (index < 12) Done(index);
  }
  // Both are at work, nothing lies ready, and there is one for each.
  EXPECT_EQ(part(12).worker, "d");
  EXPECT_EQ(part(13).worker, "d2");
  EXPECT_EQ(part(14).worker, "");
  EXPECT_EQ(part(15).worker, "");
  Done(13);
  EXPECT_EQ(part(14).worker, "d2");
  EXPECT_EQ(part(15).worker, "");
  Done(14);
  EXPECT_EQ(part(15).worker, "d2") << "the other is still at its own";
}

TEST_F(PartsAheadTest, ALostDiscretizerLosesBothAndOneOfThemIsNoLossOfIts) {
  BeginWithTwo();
  Accept(0);
  actions_.Orders();
  Lose("d");
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("revoke d j1 1 2.0/16", "revoke d j1 1 0.0/16"));
  EXPECT_EQ(job().message, "part 1 of 16 starts again: d was lost");
  EXPECT_EQ(part(0).attempt, 1u);
  EXPECT_EQ(part(0).losses, 1u);
  EXPECT_EQ(part(2).attempt, 1u) << "it may be begun yet";
  EXPECT_EQ(part(2).losses, 0u);
  Accept(1);
  EXPECT_THAT(actions_.Orders(), ElementsAre("d2 j1 1 3.0/16 > s"))
      << "ahead only what was never lost";
  Done(1);
  Accept(3);
  actions_.Orders();
  Done(3);
  Done(part(4).worker.empty() ? 5 : 4);
  EXPECT_FALSE(part(0).done);
}

// Each may be lost once before it is begun, and three times at work.
TEST_F(PartsAheadTest, APartHasAsManyNumbersAsItCanBeLost) {
  BeginWithTwo();
  Lose("d2");
  Accept(0);
  ASSERT_EQ(part(2).worker, "d");
  Lose("d");
  EXPECT_EQ(part(2).attempt, 1u);
  for (std::uint32_t loss = 1; loss <= host::kMaxPartLosses; ++loss) {
    const std::string name = fmt::format("e{}", loss);
    Ready(name, intaglio_ROLE_DISCRETIZER);
    queue_.Turn(now_);
    // Until it has the part that is to be lost.
    while (part(2).worker != name) {
      const auto has = std::find_if(
          job().parts.begin(), job().parts.end(),
          [&](const PartRecord& one) { return one.worker == name && !one.done; });
      ASSERT_NE(has, job().parts.end());
      Done(static_cast<std::uint32_t>(has - job().parts.begin()));
    }
    EXPECT_LT(part(2).attempt, host::kMaxPartAttempts);
    EXPECT_EQ(job().state, intaglio_JOB_DISCRETIZING);
    Lose(name);
  }
  EXPECT_EQ(job().state, intaglio_JOB_FAILED);
  EXPECT_EQ(job().message, "part 3 of 16 has failed after 3 attempts; e3 was lost");
}

TEST_F(PartsAheadTest, OneThatFailsForANeighbourLeavesTheNextToItsWorker) {
  BeginWithTwo();
  Accept(0);
  Accept(2);
  actions_.Orders();
  Fail(0, intaglio_ERROR_LINK_LOST);
  EXPECT_EQ(part(0).worker, "");
  EXPECT_EQ(part(2).worker, "d");
  EXPECT_EQ(part(2).attempt, 0u);
  Done(2);
  EXPECT_TRUE(part(2).done);
}

TEST_F(PartsAheadTest, TheEndOfTheJobRevokesBoth) {
  BeginWithTwo();
  Accept(0);
  actions_.Orders();
  ASSERT_TRUE(Command(intaglio_COMMAND_CANCEL));
  EXPECT_THAT(actions_.Orders(),
              ElementsAre("stop j1", "revoke d j1 1 0.0/16", "revoke d2 j1 1 1.0/16",
                          "revoke d j1 1 2.0/16", "revoke s j1 1", "revoke y j1 1"));
}

TEST_F(PartsAheadTest, OneThatDoesNotBeginItsNextPartIsSilent) {
  BeginWithTwo();
  Accept(0);
  Done(0);
  for (const auto stage : {intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
    Task(stage, intaglio_TASK_ACCEPTED);
  }
  Accept(1);
  actions_.Orders();
  now_ += 11s;
  Ready("d", intaglio_ROLE_DISCRETIZER, intaglio_HEALTH_BUSY);
  Ready("d2", intaglio_ROLE_DISCRETIZER, intaglio_HEALTH_BUSY);
  Ready("s", intaglio_ROLE_SORTER, intaglio_HEALTH_BUSY);
  Ready("y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_BUSY);
  queue_.Turn(now_);
  EXPECT_THAT(actions_.Orders(), ElementsAre("revoke d j1 1 2.0/16"));
  EXPECT_EQ(job().message, "part 3 of 16 starts again: d does not answer");
}

/// Discretizers that work, fail and die at random; each does its tasks in their order.
class RandomShop : public JobActions {
 public:
  explicit RandomShop(std::uint32_t seed) : random_(seed) {}

  void Changed(const JobRecord&) override {}
  void Progressed(const JobRecord&) override {}
  void StopFeed(const std::string&) override {}
  void Forgotten(const JobRecord&) override {}
  void WorkerForgotten(const std::string&) override {}
  void PieceChanged(const PieceRecord& /*piece*/) override {}
  void BlockLoaded(const LoadedBlock& /*block*/) override {}
  void LeftOutChanged(const LeftOut& /*worker*/) override {}
  void Give(const TaskOrder& order, const JobRecord&) override {
    if (order.stage != intaglio_STAGE_DISCRETIZE) return;
    const auto found = tasks_.find(order.worker);
    if (found == tasks_.end()) return;  // it is dead
    std::deque<Given>& tasks = found->second;
    if (order.revoked) return tasks.clear();
    EXPECT_LT(tasks.size(), 2u);
    EXPECT_TRUE(tasks.empty() || tasks.back().accepted) << "two on their way";
    EXPECT_TRUE(used_.insert({order.task.part, order.task.part_attempt}).second);
    EXPECT_LT(order.task.part_attempt, host::kMaxPartAttempts);
    tasks.push_back({order.task, false});
  }

  /// One event; false when nothing can happen without a new discretizer.
  void Happen(JobQueue& queue, Nanoseconds now, int& deaths_left) {
    if (tasks_.empty() || Upto(20) == 0) return Join(queue, now);
    auto worker = std::next(tasks_.begin(), Upto(static_cast<int>(tasks_.size()) - 1));
    const std::string name = worker->first;
    if (deaths_left > 0 && Upto(15) == 0) {
      --deaths_left;
      tasks_.erase(worker);
      return queue.WorkerLost(name, now);
    }
    std::deque<Given>& tasks = worker->second;
    if (tasks.empty()) return Health(queue, name, now);
    for (Given& given : tasks) {
      if (given.accepted) continue;
      given.accepted = true;
      return Report(queue, name, given.task, intaglio_TASK_ACCEPTED, now);
    }
    const TaskId task = tasks.front().task;
    tasks.pop_front();
    Report(queue, name, task, Upto(30) == 0 ? intaglio_TASK_FAILED : intaglio_TASK_DONE,
           now);
    Health(queue, name, now);
  }
  void Join(JobQueue& queue, Nanoseconds now) {
    if (tasks_.size() > 3) return;
    const std::string name = fmt::format("w{}", joined_++);
    tasks_[name];
    Health(queue, name, now);
  }

 private:
  struct Given {
    TaskId task;
    bool accepted;
  };
  int Upto(int largest) { return std::uniform_int_distribution(0, largest)(random_); }
  void Health(JobQueue& queue, const std::string& name, Nanoseconds now) {
    const bool idle = tasks_.at(name).empty();
    queue.Receive(WorkerView{name, intaglio_ROLE_DISCRETIZER,
                             idle ? intaglio_HEALTH_READY : intaglio_HEALTH_BUSY, "", ""},
                  now);
  }
  static void Report(JobQueue& queue, const std::string& name, const TaskId& task,
                     intaglio_TaskState state, Nanoseconds now) {
    TaskView report;
    report.task = task;
    report.worker = name;
    report.state = state;
    report.done_count = report.total_count = 10;
    if (state == intaglio_TASK_FAILED) report.error_code = intaglio_ERROR_LINK_LOST;
    queue.Receive(report, now);
  }

  std::mt19937 random_;
  std::map<std::string, std::deque<Given>> tasks_;  // of those that live
  std::set<std::pair<std::uint32_t, std::uint32_t>> used_;
  int joined_ = 0;
};

TEST(PartsAheadAtRandom, EveryPartIsMadeAndNoNumberGivenTwice) {
  int sorted = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    RandomShop shop(seed);
    JobQueue queue(shop);
    Nanoseconds now = 100s;
    for (int i = 0; i < 2; ++i) shop.Join(queue, now);
    queue.Receive(WorkerView{"s", intaglio_ROLE_SORTER, intaglio_HEALTH_READY, "", ""},
                  now);
    queue.Receive(
        WorkerView{"y", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "c", ""}, now);
    JobRecord record;
    record.number = 1;
    record.uid = "j1";
    record.cell = "c";
    queue.Add(record);
    queue.Turn(now);
    const JobRecord& job = *queue.Find("j1");
    int deaths_left = 4;
    for (int i = 0; i < 5000 && job.state == intaglio_JOB_DISCRETIZING; ++i) {
      now += 50ms;
      shop.Happen(queue, now, deaths_left);
      // The other two are not what is tested.
      for (const char* other : {"s", "y"}) {
        const bool sorts = other[0] == 's';
        queue.Receive(
            WorkerView{other, sorts ? intaglio_ROLE_SORTER : intaglio_ROLE_SYNCHRONIZER,
                       intaglio_HEALTH_BUSY, sorts ? "" : "c", ""},
            now);
        TaskView report;
        report.task = {"j1", job.attempt, 0, 0};
        report.stage = sorts ? intaglio_STAGE_SORT : intaglio_STAGE_ENGRAVE;
        report.worker = other;
        queue.Receive(report, now);
      }
      queue.Turn(now);
    }
    if (job.state == intaglio_JOB_FAILED) {
      EXPECT_THAT(job.message, testing::HasSubstr("has failed after 3 attempts"));
      continue;
    }
    ASSERT_EQ(job.state, intaglio_JOB_SORTING) << "seed " << seed;
    EXPECT_EQ(job.stage(intaglio_STAGE_DISCRETIZE).done_count, 160u) << "seed " << seed;
    ++sorted;
  }
  EXPECT_GT(sorted, 250);
}

}  // namespace
}  // namespace intaglio::job_service
