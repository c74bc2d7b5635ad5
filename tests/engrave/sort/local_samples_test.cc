#include "engrave/sort/local_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace intaglio::sort {
namespace {

/// A lattice of a millimetre, 10 x 10 x 40 points, the lowest first.
PointList Tower() {
  PointList points_mm;
  for (int z = 0; z < 40; ++z) {
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 10; ++x) points_mm.push_back(Vec3(x, y, z));
    }
  }
  return points_mm;
}

TEST(LocalSamples, AreNeighboursAtAllHeights) {
  const PointList points_mm = Tower();
  const auto samples = LocalSamples(points_mm, 4, 100);
  ASSERT_EQ(samples.size(), 4u);
  double last_mm = -1;
  for (const auto& sample : samples) {
    EXPECT_EQ(std::set(sample.begin(), sample.end()).size(), 100u);
    EXPECT_TRUE(std::is_sorted(sample.begin(), sample.end()));
    Box3 box;
    for (const std::uint32_t index : sample) box.Extend(points_mm.at(index));
    // A ball of a hundred lattice points has a radius of 2.9 mm; at a wall, half of one
    // 3.6 mm, at an edge of the tower a quarter of one 4.6 mm: 9.2 mm along the edge.
    EXPECT_LT(box.size_mm().maxCoeff(), 9.2);
    EXPECT_GT(box.center_mm().z(), last_mm + 5);
    last_mm = box.center_mm().z();
  }
}

// 100 points are a layer of the tower.
TEST(LocalSamples, ByHeightHaveAllThatIsAsHigh) {
  const PointList points_mm = Tower();
  for (const auto& sample : LocalSamples(points_mm, 4, 300, true)) {
    std::map<double, int> of_height;
    for (const std::uint32_t index : sample) ++of_height[points_mm.at(index).z()];
    EXPECT_EQ(of_height.size(), 3u);
    for (const auto& [z_mm, count] : of_height) EXPECT_EQ(count, 100) << z_mm;
  }
}

TEST(LocalSamples, OfASmallCloudIsAllOfIt) {
  const PointList points_mm = Tower();
  const auto samples = LocalSamples(points_mm, 4, 1000);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].size(), points_mm.size());
  EXPECT_EQ(LocalSamples(points_mm, 4, 100), LocalSamples(points_mm, 4, 100));
}

}  // namespace
}  // namespace intaglio::sort
