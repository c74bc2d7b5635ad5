#include "engrave/discretize/spacing/fixed_points.h"

#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::discretize {
namespace {

SpacedCloud Spiral(int count) {
  SpacedCloud cloud;
  for (int i = 0; i < count; ++i) {
    cloud.Add({std::cos(i), std::sin(i), std::fmod(i * 0.37, 5.0)}, 0, 0.01F * i);
  }
  return cloud;
}

TEST(FixedPoints, RangesShareOutThePointsAndTheStatistics) {
  MethodStatistics reported;
  reported.plane_count = 7;
  reported.point_count = 99;  // is counted anew
  const auto source = MakeFixedPoints(Spiral(200), reported);
  EXPECT_NEAR(source->MaxSpacing(), 1.99, 1e-6);
  SpacedCloud whole, parts;
  const auto all = source->AddPoints({}, 3, {}, whole);
  EXPECT_EQ(all->point_count, 200);
  EXPECT_EQ(all->plane_count, 7);
  MethodStatistics sum;
  for (double low = 0; low < 5; low += 0.5) {
    const auto part = source->AddPoints({low, low + 0.5}, 3, {}, parts);
    sum.Add(*part);
  }
  EXPECT_EQ(sum.point_count, 200);
  EXPECT_EQ(sum.plane_count, 7);
  EXPECT_EQ(parts.points_mm, whole.points_mm);
  EXPECT_EQ(parts.spacing_mm, whole.spacing_mm);
  EXPECT_EQ(whole.source, std::vector<std::uint32_t>(200, 3));
}

TEST(FixedPoints, ARangeHoldsItsLowEndAndNotItsHighEnd) {
  SpacedCloud two;
  two.Add({0, 0, 1}, 0);
  two.Add({0, 0, 2}, 0);
  const auto source = MakeFixedPoints(two);
  SpacedCloud cloud;
  EXPECT_EQ(source->AddPoints({1, 2}, 0, {}, cloud)->point_count, 1);
  EXPECT_EQ(cloud.points_mm.at(0).z(), 1);
}

TEST(FixedPoints, NoPointsHaveNoBounds) {
  const auto source = MakeFixedPoints({});
  EXPECT_TRUE(source->Bounds().empty());
  SpacedCloud cloud;
  EXPECT_EQ(source->AddPoints({}, 0, {}, cloud)->point_count, 0);
}

}  // namespace
}  // namespace intaglio::discretize
