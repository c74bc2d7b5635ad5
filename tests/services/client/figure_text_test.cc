#include "services/client/figure_text.h"

#include <gtest/gtest.h>

namespace intaglio::client {
namespace {

TEST(FigureText, DistanceFromTheBoundIsRoundedUp) {
  EXPECT_EQ(AboveBound(1014, 1000), ", at most 1.4 % above the best possible");
  EXPECT_EQ(AboveBound(16199, 16178), ", at most 0.2 % above the best possible");
  EXPECT_EQ(AboveBound(100001, 100000), ", at most 0.1 % above the best possible");
  EXPECT_EQ(AboveBound(3000, 1000), ", at most 200.0 % above the best possible");
  EXPECT_EQ(AboveBound(1000, 1000), ", the best possible");
}

TEST(FigureText, ANounAgreesWithItsGroupedNumber) {
  EXPECT_EQ(GroupedCount(1, "point"), "1 point");
  EXPECT_EQ(GroupedCount(1234, "point"), "1 234 points");
}

}  // namespace
}  // namespace intaglio::client
