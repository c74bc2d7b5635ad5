#include "engrave/contour/drill_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::contour {
namespace {

using ::testing::ElementsAre;

TEST(DrillPlan, GrowsAndChangesToolsWhereTheLastEnded) {
  const std::vector<Hole> holes = {{{0, 5}, 1.2}, {{9, 0}, 0.8}, {{1, 0}, 0.8},
                                   {{8, 0}, 1.2}, {{5, 0}, 0.8}, {{3, 3}, 3.0}};
  const auto tools = PlanDrilling(holes, Vec2::Zero(), OrderKind::kNearest);
  ASSERT_EQ(tools.size(), 3U);
  EXPECT_EQ(tools[0].diameter_mm, 0.8);
  EXPECT_THAT(tools[0].holes, ElementsAre(2, 4, 1));
  EXPECT_EQ(tools[1].diameter_mm, 1.2);
  EXPECT_THAT(tools[1].holes, ElementsAre(3, 0));  // from (9, 0)
  EXPECT_EQ(tools[2].diameter_mm, 3.0);
  EXPECT_THAT(tools[2].holes, ElementsAre(5));
}

// By turns within a tool, each from where the turn before ended.
TEST(DrillPlan, TurnsGoBeforeTheWay) {
  const std::vector<Hole> holes = {{{1, 0}, 1, 2}, {{2, 0}, 1},    {{3, 0}, 1, 1},
                                   {{4, 0}, 1},    {{5, 0}, 2, 0}, {{6, 0}, 1, 1}};
  for (const OrderKind kind : {OrderKind::kNearest, OrderKind::kImproved}) {
    const auto tools = PlanDrilling(holes, Vec2::Zero(), kind);
    ASSERT_EQ(tools.size(), 2U);
    EXPECT_THAT(tools[0].holes, ElementsAre(1, 3, 2, 5, 0));
    EXPECT_THAT(tools[1].holes, ElementsAre(4));
  }
}

TEST(DrillPlan, TakesOneToolForDiametersThatDifferByRounding) {
  const std::vector<Hole> holes = {{{0, 0}, 0.8001}, {{1, 0}, 0.8}, {{2, 0}, 0.9}};
  EXPECT_EQ(PlanDrilling(holes, Vec2::Zero()).size(), 2U);
  EXPECT_TRUE(PlanDrilling({}, Vec2::Zero()).empty());
}

}  // namespace
}  // namespace intaglio::contour
