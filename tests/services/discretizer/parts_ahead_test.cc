// Parts that the program is given while it is at another one.

#include <gtest/gtest.h>

#include "services/platform/host/stage/flow.h"
#include "tests/services/discretizer/box_model.h"
#include "tests/services/platform/host/stage/stage_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using test::BoxStl;
using test::Eventually;
using test::FeedModels;
using test::FrozenJobOf;
using test::StageShop;

JobSpec BoxJob() {
  JobSpec spec;
  spec.add_models()->set_file("/nowhere/box.stl");
  auto& size = *spec.mutable_block()->mutable_size_mm();
  size.set_x(30), size.set_y(30), size.set_z(30);
  spec.mutable_discretization()->set_min_spacing_mm(0.1);
  spec.mutable_discretization()->mutable_sections();
  return spec;
}

class PartsAheadTest : public testing::Test {
 protected:
  PartsAheadTest() { EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY)); }

  void Give(std::uint32_t part) {
    shop.Give(FrozenJobOf("box", BoxJob()), 1, "sorter", {part, 4, 0});
  }
  bool Feed() { return FeedModels(shop.bus(), "box", 1, {BoxStl(17, 8, 19)}, {0, 4, 0}); }
  bool Reports(std::uint32_t part, intaglio_TaskState state) {
    return Eventually(
        [&] {
          return shop.Find("box", {part, 4, 0}, state).has_value();
        },
        20s);
  }
  bool HasReported(std::uint32_t part, intaglio_TaskState state) {
    return shop.Find("box", {part, 4, 0}, state).has_value();
  }
  /// It is made, but not sent: no consumer has granted credit.
  bool IsMade(std::uint32_t part) {
    const auto report = shop.AwaitReport("box", [part](const test::TaskReport& one) {
      return one.part.index == part && one.state == intaglio_TASK_RUNNING &&
             one.done_count > 1000 && one.done_count == one.total_count;
    });
    return report.has_value();
  }
  PointCloud Consume() {
    Result<bool> taken = false;
    Eventually([&] { return taken = intake.Poll(), !taken || *taken; }, 20s);
    EXPECT_TRUE(taken && *taken) << (taken ? "not whole" : taken.error().message);
    return taken && *taken ? intake.TakeContent() : PointCloud();
  }

  StageShop shop{"intaglio-discretizer", intaglio_STAGE_DISCRETIZE, bus::kDiscretizeTask};
  host::PointIntake intake{shop.bus(), "sorter", bus::kPointBatch};
};

TEST_F(PartsAheadTest, TheNextOneIsMadeWhileTheOneBeforeWaitsToBeSent) {
  Give(0);
  // Before its model comes: then it is at work, and what it reported before is gone.
  ASSERT_TRUE(Reports(0, intaglio_TASK_ACCEPTED));
  ASSERT_TRUE(Feed());
  Give(1);
  ASSERT_TRUE(IsMade(0));
  EXPECT_TRUE(IsMade(1));
  EXPECT_FALSE(HasReported(0, intaglio_TASK_DONE));
  // It is not begun: the memory of a discretizer holds two parts.
  Give(2);
  ASSERT_TRUE(Reports(2, intaglio_TASK_ACCEPTED));
  EXPECT_FALSE(Eventually([&] { return HasReported(2, intaglio_TASK_RUNNING); }, 300ms));
  Give(3);
  ASSERT_TRUE(Reports(3, intaglio_TASK_ACCEPTED));

  ASSERT_TRUE(intake.Open("box", 1, 4));
  const PointCloud parts = Consume();
  for (std::uint32_t part = 0; part < 4; ++part) {
    EXPECT_TRUE(Reports(part, intaglio_TASK_DONE)) << part;
  }
  EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));

  ASSERT_TRUE(intake.Open("whole", 1));
  shop.Give(FrozenJobOf("whole", BoxJob()), 1, "sorter");
  ASSERT_TRUE(FeedModels(shop.bus(), "whole", 1, {BoxStl(17, 8, 19)}));
  const PointCloud whole = Consume();
  EXPECT_GT(whole.size(), 10'000u);
  EXPECT_EQ(parts.points_mm, whole.points_mm);
  EXPECT_EQ(parts.source, whole.source);
}

// One sample a worker is retained: the others' revocations may never be seen.
TEST_F(PartsAheadTest, ARevocationTakesAllOfTheChain) {
  Give(0);
  ASSERT_TRUE(Feed());
  ASSERT_TRUE(IsMade(0));
  for (const std::uint32_t part : {1, 2}) {
    Give(part);
    ASSERT_TRUE(Reports(part, intaglio_TASK_ACCEPTED));
  }
  shop.Revoke("box", 1, {2, 4, 0});
  for (std::uint32_t part = 0; part < 3; ++part) {
    const auto end = shop.AwaitEnd("box", 1, {part, 4, 0});
    ASSERT_TRUE(end) << part;
    EXPECT_EQ(end->state, intaglio_TASK_FAILED);
    EXPECT_EQ(end->error_code, intaglio_ERROR_CANCELLED);
  }
  EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
}

TEST_F(PartsAheadTest, ATaskOfAnotherChainTakesThePlaceOfAll) {
  Give(0);
  ASSERT_TRUE(Reports(0, intaglio_TASK_ACCEPTED));
  ASSERT_TRUE(Feed());
  Give(1);
  ASSERT_TRUE(Reports(1, intaglio_TASK_ACCEPTED));
  shop.Give(FrozenJobOf("other", BoxJob()), 1, "");
  for (const std::uint32_t part : {0, 1}) {
    const auto end = shop.AwaitEnd("box", 1, {part, 4, 0});
    ASSERT_TRUE(end) << part;
    EXPECT_EQ(end->state, intaglio_TASK_FAILED);
  }
  ASSERT_TRUE(FeedModels(shop.bus(), "other", 1, {BoxStl(17, 8, 19)}));
  const auto end = shop.AwaitEnd("other", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_DONE) << end->message;
}

// The consumer wants no more of either; each fails for itself, and the worker is free.
TEST_F(PartsAheadTest, EachFailsForItself) {
  ASSERT_TRUE(intake.Open("box", 1, 4));
  Give(0);
  ASSERT_TRUE(Reports(0, intaglio_TASK_ACCEPTED));
  Give(1);
  intake.Close();
  ASSERT_TRUE(Feed());
  for (const std::uint32_t part : {0, 1}) {
    const auto end = shop.AwaitEnd("box", 1, {part, 4, 0});
    ASSERT_TRUE(end) << part;
    EXPECT_EQ(end->state, intaglio_TASK_FAILED);
    EXPECT_EQ(end->error_code, intaglio_ERROR_LINK_LOST);
  }
  EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
}

}  // namespace
}  // namespace intaglio
