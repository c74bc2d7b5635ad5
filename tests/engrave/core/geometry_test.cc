#include "engrave/core/geometry.h"

#include <gtest/gtest.h>

namespace intaglio {
namespace {

TEST(Box3, IsEmptyWhenConstructed) {
  const Box3 box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(box.size_mm(), Vec3(0, 0, 0));
  EXPECT_FALSE(box.Contains(Vec3(0, 0, 0)));
}

TEST(Box3, OfOnePointIsNotEmptyAndHasNoSize) {
  Box3 box;
  box.Extend(Vec3(1, -2, 3));
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.size_mm(), Vec3(0, 0, 0));
  EXPECT_EQ(box.center_mm(), Vec3(1, -2, 3));
  EXPECT_TRUE(box.Contains(Vec3(1, -2, 3)));
}

TEST(Box3, SpansItsPointsAndContainsItsWalls) {
  Box3 box;
  box.Extend(Vec3(1, 5, -1));
  box.Extend(Vec3(-1, 7, 3));
  EXPECT_EQ(box.min_mm, Vec3(-1, 5, -1));
  EXPECT_EQ(box.max_mm, Vec3(1, 7, 3));
  EXPECT_EQ(box.size_mm(), Vec3(2, 2, 4));
  EXPECT_EQ(box.center_mm(), Vec3(0, 6, 1));
  EXPECT_TRUE(box.Contains(Vec3(1, 7, 3)));
  EXPECT_FALSE(box.Contains(Vec3(0, 7.0000001, 1)));
}

TEST(PointCloud, KeepsPointAndSourceTogether) {
  PointCloud cloud;
  cloud.Add(Vec3(1, 2, 3), 7);
  cloud.Add(Vec3(4, 5, 6), 0);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.points_mm[1], Vec3(4, 5, 6));
  EXPECT_EQ(cloud.source, (std::vector<std::uint32_t>{7, 0}));
}

}  // namespace
}  // namespace intaglio
