#include "engrave/discretize/several.h"

#include <gtest/gtest.h>

#include "engrave/discretize/spacing/fixed_points.h"

namespace intaglio::discretize {
namespace {

std::unique_ptr<PointSource> Column(double x_mm) {
  SpacedCloud cloud;
  for (int i = 0; i < 10; ++i) cloud.Add({x_mm, 0, 0.3 * i}, 0, 0.25F);
  return MakeFixedPoints(std::move(cloud));
}

TEST(Several, CopiesLieWhereTheGridStates) {
  const PointList corner = GridOffsets({2, 1, 3}, {5, 7, 4}, false);
  EXPECT_EQ(
      corner,
      (PointList{{0, 0, 0}, {5, 0, 0}, {0, 0, 4}, {5, 0, 4}, {0, 0, 8}, {5, 0, 8}}));
  const PointList centred = GridOffsets({3, 2, 1}, {5, 7, 4}, true);
  EXPECT_EQ(centred, (PointList{{-5, -3.5, 0},
                                {0, -3.5, 0},
                                {5, -3.5, 0},
                                {-5, 3.5, 0},
                                {0, 3.5, 0},
                                {5, 3.5, 0}}));
}

TEST(Several, RangesOfCopiesShareOutEveryPoint) {
  const std::shared_ptr<const PointSource> column = Column(0);
  std::vector<std::unique_ptr<PointSource>> copies;
  for (const Vec3& offset : GridOffsets({2, 2, 2}, {1, 1, 0.1}, true)) {
    copies.push_back(MakeShifted(column, offset));
  }
  const auto all = MakeSeveral(std::move(copies));
  EXPECT_EQ(all->MaxSpacing(), 0.25);
  const Box3 bounds = all->Bounds();
  EXPECT_NEAR(bounds.min_mm.z(), -0.05, 1e-12);
  EXPECT_NEAR(bounds.max_mm.z(), 2.75, 1e-12);
  SpacedCloud whole, parts;
  EXPECT_EQ(all->AddPoints({}, 4, {}, whole)->point_count, 80);
  std::uint64_t count = 0;
  for (int k = -3; k < 30; ++k) {
    const auto part = all->AddPoints({0.1 * k, 0.1 * (k + 1)}, 4, {}, parts);
    count += part->point_count;
  }
  EXPECT_EQ(count, 80);
  EXPECT_EQ(parts.size(), whole.size());
  EXPECT_EQ(whole.source, std::vector<std::uint32_t>(80, 4));
  for (const Vec3& p : parts.points_mm) {
    EXPECT_TRUE(std::find(whole.points_mm.begin(), whole.points_mm.end(), p) !=
                whole.points_mm.end());
  }
}

}  // namespace
}  // namespace intaglio::discretize
