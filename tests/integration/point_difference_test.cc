#include "tests/integration/point_difference.h"

#include <gtest/gtest.h>

namespace intaglio::testing {
namespace {

const Vec3 kA(0, 0, 0), kB(1, 0, 0), kC(0, 1, 0);

TEST(PointDifference, IsNoneInWhateverOrderEachPointWasMadeOnce) {
  EXPECT_EQ(PointDifference({kA, kB, kC}, {kA, kB, kC}, 0.01), "");
  EXPECT_EQ(PointDifference({kA, kB, kC}, {kC, kA, kB + Vec3(0, 0, 0.009)}, 0.01), "");
  EXPECT_EQ(PointDifference({}, {}, 0.01), "");
}

TEST(PointDifference, CountsHowOftenEachIsPlannedAndMade) {
  EXPECT_EQ(PointDifference({kA, kB, kA}, {kA, kA, kB}, 0.01), "");
  EXPECT_EQ(PointDifference({kA, kB}, {kB, kA, kB}, 0.01),
            "point 1 is made again by 2\n");
  EXPECT_EQ(PointDifference({kA, kA, kB}, {kB, kA}, 0.01), "1 points are missing\n");
}

// As many pulses as points are not enough.
TEST(PointDifference, FindsADoubledPointInPlaceOfAnother) {
  EXPECT_EQ(PointDifference({kA, kB, kC}, {kA, kB, kB}, 0.01),
            "point 1 is made again by 2\n1 points are missing\n");
}

TEST(PointDifference, FindsWhatIsBesideEveryPoint) {
  EXPECT_EQ(PointDifference({kA, kB}, {kA, kB + Vec3(0, 0, 0.02)}, 0.01),
            "1 is 0.020 mm from any point\n1 points are missing\n");
}

}  // namespace
}  // namespace intaglio::testing
