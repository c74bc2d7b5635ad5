#include "engrave/sort/travel.h"

#include <gtest/gtest.h>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

const PointList kPoints = {{0, 0, 0}, {3, 4, 0}, {3, 4, -12}};

TEST(Travel, SumsTheSteps) {
  const Travel travel = MeasureTravel(kPoints, {1, 0, 2});
  EXPECT_DOUBLE_EQ(travel.largest_axis_mm, 4 + 12);
  EXPECT_DOUBLE_EQ(travel.euclidean_mm, 5 + 13);
  EXPECT_DOUBLE_EQ(travel.longest_step_mm, 12);
}

TEST(Travel, OfNoStepIsNothing) {
  EXPECT_EQ(MeasureTravel(kPoints, {}).euclidean_mm, 0);
  EXPECT_EQ(MeasureTravel(kPoints, {2}).largest_axis_mm, 0);
  EXPECT_THROW(MeasureTravel(kPoints, {3}), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
