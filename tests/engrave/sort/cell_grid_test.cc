#include "engrave/sort/near/cell_grid.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

std::vector<Scaled> Floats(const PointList& points_mm) {
  std::vector<Scaled> points;
  for (const Vec3& p : points_mm) {
    points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                      static_cast<float>(p.z())});
  }
  return points;
}

bool IsIn(const Scaled& p, const Scaled& low, const Scaled& high) {
  return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y &&
         p.z <= high.z;
}

// Boxes within the cloud, beside it and around it; cells of any size.
TEST(CellGrid, FindsEveryPointOfABoxOnce) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  for (const auto& [name, points_mm] : Clouds(300)) {
    const std::vector<Scaled> points = Floats(points_mm);
    for (const float cell : {0.1F, 0.3F, 2.0F, 1e30F}) {
      const CellGrid grid(points, cell);
      for (int i = 0; i < 20; ++i) {
        const Scaled middle = points[random() % points.size()];
        const Scaled half{2 * unit(random), 2 * unit(random), 2 * unit(random)};
        const Scaled low{middle.x - half.x, middle.y - half.y, middle.z - half.z};
        const Scaled high{middle.x + half.x, middle.y, middle.z + half.z};
        std::vector<int> found(points.size());
        EXPECT_TRUE(grid.ForEachInCells(grid.CellOf(low), grid.CellOf(high),
                                        [&](std::uint32_t p) {
                                          ++found[p];
                                          return true;
                                        }));
        for (std::size_t p = 0; p < points.size(); ++p) {
          EXPECT_LE(found[p], 1) << name;
          if (IsIn(points[p], low, high)) {
            EXPECT_EQ(found[p], 1) << name << " " << cell;
          }
        }
      }
    }
  }
}

TEST(CellGrid, EndsWhenThePointIsNotTaken) {
  const std::vector<Scaled> points = Floats(Row(9, {1, 0, 0}));
  const CellGrid grid(points, 1);
  int seen = 0;
  EXPECT_FALSE(grid.ForEachInCells({0, 0, 0}, {20, 20, 20},
                                   [&](std::uint32_t) { return ++seen < 4; }));
  EXPECT_EQ(seen, 4);
}

}  // namespace
}  // namespace intaglio::sort
