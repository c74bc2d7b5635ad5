#include "services/cli/batch/batch_plan.h"

#include <gmock/gmock.h>

#include <random>
#include <set>

namespace intaglio::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using State = BatchPlan::State;

const std::vector<std::string> kBoth = {"a", "b"};

std::vector<std::string> Starts(BatchPlan& plan) {
  std::vector<std::string> texts;
  for (const auto& start : plan.Next()) {
    texts.push_back(std::to_string(start.job) + start.cell);
  }
  return texts;
}

TEST(BatchPlan, OneJobAMachineAtATime) {
  BatchPlan plan({{{}, 0, kBoth}, {{}, 0, kBoth}, {{}, 0, kBoth}, {{}, 0, {"b"}}}, 0);
  EXPECT_THAT(Starts(plan), ElementsAre("0a", "1b"));
  EXPECT_THAT(Starts(plan), IsEmpty());
  plan.Ended(1, true);
  EXPECT_THAT(Starts(plan), ElementsAre("2b"));
  plan.Ended(0, true);
  EXPECT_THAT(Starts(plan), IsEmpty()) << "the fourth is for b alone";
  plan.Ended(2, true);
  EXPECT_THAT(Starts(plan), ElementsAre("3b"));
  EXPECT_FALSE(plan.over());
  plan.Ended(3, true);
  EXPECT_TRUE(plan.over());
}

TEST(BatchPlan, ParallelIsABoundOverAllAndSharedByTheMachines) {
  BatchPlan one({{{}, 0, kBoth}, {{}, 0, kBoth}}, 1);
  EXPECT_THAT(Starts(one), ElementsAre("0a"));
  BatchPlan three({4, {{}, 0, kBoth}}, 3);
  EXPECT_THAT(Starts(three), ElementsAre("0a", "1b", "2a"));
}

TEST(BatchPlan, HigherPrioritiesFirst) {
  BatchPlan plan({{{}, 0, {"a"}}, {{}, 5, {"a"}}, {{}, 5, {"a"}}, {{}, -1, {"a"}}}, 0);
  for (const char* next : {"1a", "2a", "0a", "3a"}) {
    EXPECT_THAT(Starts(plan), ElementsAre(next));
    plan.Ended(static_cast<std::size_t>(next[0] - '0'), true);
  }
}

TEST(BatchPlan, WhatComesAfterABadOneIsSkipped) {
  BatchPlan plan({{{}, 0, {"a"}},
                  {{0}, 9, {"a"}},
                  {{1}, 0, {"b"}},
                  {{3, 0}, 0, {"b"}},
                  {{}, 0, {"b"}}},
                 4);
  EXPECT_THAT(Starts(plan), ElementsAre("0a", "4b"));
  EXPECT_THAT(plan.Ended(0, false), ElementsAre(1, 2, 3));
  EXPECT_EQ(plan.state(2), State::kSkipped);
  EXPECT_THAT(plan.Ended(4, true), IsEmpty());
  EXPECT_TRUE(plan.over());
  EXPECT_EQ(plan.count(State::kSkipped), 3u);
}

TEST(BatchPlan, AfterAStopWhatIsOutGoesOn) {
  BatchPlan plan({{{}, 0, {"a"}}, {{}, 0, {"a"}}}, 0);
  EXPECT_THAT(Starts(plan), ElementsAre("0a"));
  plan.Stop();
  EXPECT_FALSE(plan.over());
  plan.Ended(0, true);
  EXPECT_TRUE(plan.over());
  EXPECT_THAT(Starts(plan), IsEmpty());
  EXPECT_EQ(plan.state(1), State::kWaiting);
}

// Whatever the batch: it ends, nothing begins twice or too early, and no machine has more
// than its share.
TEST(BatchPlan, AnyBatchComesToItsEnd) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    std::vector<PlannedJob> jobs(random() % 30 + 1);
    for (std::size_t i = 0; i < jobs.size(); ++i) {
      if (i > 0 && random() % 2 == 0) jobs[i].after.push_back(random() % i);
      jobs[i].priority = static_cast<int>(random() % 3);
      jobs[i].cells = random() % 2 == 0 ? kBoth : std::vector<std::string>{"b"};
    }
    const std::size_t parallel = random() % 5;
    BatchPlan plan(jobs, parallel);
    std::vector<std::size_t> out;
    std::set<std::size_t> begun;
    for (int turns = 0; !plan.over(); ++turns) {
      ASSERT_LT(turns, 1000) << seed;
      for (const auto& start : plan.Next()) {
        EXPECT_TRUE(begun.insert(start.job).second);
        for (const std::size_t before : jobs[start.job].after) {
          EXPECT_EQ(plan.state(before), State::kGood);
        }
        out.push_back(start.job);
      }
      EXPECT_LE(out.size(), parallel == 0 ? 2 : parallel);
      ASSERT_FALSE(out.empty());
      std::swap(out[random() % out.size()], out.back());
      plan.Ended(out.back(), random() % 4 != 0);
      out.pop_back();
    }
    EXPECT_EQ(begun.size() + plan.count(State::kSkipped), jobs.size());
  }
}

}  // namespace
}  // namespace intaglio::cli
