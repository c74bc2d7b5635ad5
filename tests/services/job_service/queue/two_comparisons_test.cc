// Two jobs on two machines, each with a part that two discretizers made differently: what
// the decision about one of them means for the other.

#include "tests/services/job_service/queue/discretizer_shop.h"

namespace intaglio::job_service {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Key;
using testing::Not;

class TwoComparisons : public DiscretizerShop {
 protected:
  /// Nobody is missed: those that are at a task report, too.
  void KeepAlive() {
    now_ += 1s;
    for (const auto& [name, role] :
         {std::pair{"s", intaglio_ROLE_SORTER}, {"s2", intaglio_ROLE_SORTER}})
      Ready(name, role);
    for (const auto& [name, cell] : {std::pair{"y", "c"}, {"y2", "c2"}}) {
      queue_.Receive(
          WorkerView{name, intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, cell, ""},
          now_);
    }
    for (const char* name : {"d", "e", "f"}) {
      if (!alive_.contains(name)) continue;
      const bool works = !actions_.given[name].empty();
      queue_.Receive(
          WorkerView{name, intaglio_ROLE_DISCRETIZER,
                     works ? intaglio_HEALTH_BUSY : intaglio_HEALTH_READY, "", ""},
          now_);
    }
    queue_.Turn(now_);
  }
  /// This one works until the comparison is its oldest task, which it accepts.
  void ReachComparison(const std::string& name) {
    auto& tasks = actions_.given[name];
    while (!tasks.empty() && !host::IsComparison(tasks.front().task.part_attempt))
      ASSERT_TRUE(WorkOnce(name));
    ASSERT_FALSE(tasks.empty());
    Report(ReportOf(tasks.front(), intaglio_TASK_ACCEPTED));
  }
  const JobRecord& AddOther() {
    JobRecord job;
    job.number = ++other_number_;
    job.uid = fmt::format("other{}", other_number_);
    job.epoch = 1;
    job.cell = "c2";
    queue_.Add(job);
    KeepAlive();
    return *queue_.Find(job.uid);
  }
  void Cancel(const JobRecord& job) {
    CommandView command;
    command.sender = "bob";
    command.number = ++command_;
    command.job_uid = job.uid;
    command.epoch = 1;
    command.kind = intaglio_COMMAND_CANCEL;
    ASSERT_TRUE(queue_.Receive(command, now_).taken());
    for (const std::string& name : {std::string("d"), e_}) actions_.given[name].clear();
    for (int i = 0; i < 3; ++i) KeepAlive();
  }

  /// The first job, on machine c: d has made a part wrong, and f_ is about to compare it.
  void BeginFirst() {
    for (const char* name : {"d", "e", "f"}) Start(name);
    WorkUpToAComparison();
    wrong_ = {"d"};
    ASSERT_TRUE(WorkOnce("d"));
    Work([this] { return job().comparison && job().comparison->at_work(); });
    ASSERT_TRUE(job().comparison);
    ASSERT_EQ(job().comparison->made.front().worker, "d");
    f_ = job().comparison->worker;
    e_ = f_ == "f" ? "e" : "f";
    ReachComparison(f_);
    discretizers_.erase(f_);
    // These count to the next comparison, about.
    done_ = 0;
    for (bool any = true; any;) {
      any = false;
      for (const std::string& name : {std::string("d"), e_}) {
        if (!WorkOnce(name)) continue;
        any = true;
        ++done_;
      }
    }
    for (const auto stage : {intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE})
      Report(CellReport(stage, intaglio_TASK_ACCEPTED));
  }
  /// The second job, on machine c2: e_ has made a part, and d is about to compare it.
  const JobRecord* BeginSecond() {
    for (int i = 0; i < 10; ++i) {
      const JobRecord& other = AddOther();
      for (bool any = true; any && !other.comparison;) {
        any = false;
        for (const std::string& name : {std::string("d"), e_}) {
          if (other.comparison || (name == "d" && done_ + 12 >= kCompareEvery)) continue;
          if (!WorkOnce(name)) continue;
          any = true;
          ++done_;
        }
      }
      if (other.comparison) return &other;
      Cancel(other);
    }
    return nullptr;
  }

  std::set<std::string> alive_ = {"d", "e", "f"};
  std::string e_, f_;  // of the other two, who is in which comparison
  std::uint32_t other_number_ = 900, done_ = 0;
};

TEST_F(TwoComparisons, OneThatIsSuspectedIsTakenBackWhenTheOtherIsFoundWrongElsewhere) {
  ASSERT_NO_FATAL_FAILURE(BeginFirst());
  const JobRecord* second = BeginSecond();
  ASSERT_NE(second, nullptr);
  ASSERT_EQ(second->comparison->made.front().worker, e_);
  while (!second->comparison->at_work()) ASSERT_TRUE(WorkOnce("d"));
  ASSERT_EQ(second->comparison->worker, "d");
  ASSERT_NO_FATAL_FAILURE(ReachComparison("d"));
  // e_ is cut off for a while, so that nobody decides about d and f_.
  alive_.erase(e_);
  Kill(e_);
  ASSERT_TRUE(WorkOnce(f_));
  ASSERT_TRUE(WorkOnce("d"));
  ASSERT_EQ(second->comparison->made.size(), 2u);
  EXPECT_THAT(queue_.LeftOutNow(), ElementsAre(Key("d"), Key(f_)));
  Start(e_);
  EXPECT_THAT(queue_.LeftOutNow(), ElementsAre(Key("d"), Key("e"), Key("f")));

  // A fourth is given the first job's part, and finds that d is wrong.
  Start("g");
  ASSERT_TRUE(job().comparison);
  ASSERT_EQ(job().comparison->worker, "g");
  ASSERT_TRUE(WorkOnce("g"));
  EXPECT_THAT(queue_.LeftOutNow(), ElementsAre(Key("d")))
      << "what e and d made differently is explained";
  for (const LeftOut& kept : actions_.left_out) EXPECT_EQ(kept.worker, "d") << kept.why;
  Rest();
  KeepAlive();
  Work();
  EXPECT_EQ(second->attempt, 2u) << "it had parts of d";
  for (const PartRecord& part : second->parts) {
    EXPECT_NE(part.worker, "d");
    EXPECT_TRUE(part.done);
  }
  EXPECT_THAT(second->suspicion, "");
}

}  // namespace
}  // namespace intaglio::job_service
