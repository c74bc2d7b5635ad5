#include "engrave/sort/way/block_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

// A beam of NA 0.05 in N-BK7.
constexpr double kConeTangent = 0.033;
const Vec3 kBlockMm(45, 30, 80);

BeamLean LeanFrom(double pupil_mm) {
  BeamLean lean;
  lean.pupil_mm = Vec2::Constant(pupil_mm);
  lean.top_mm = kBlockMm.z();
  lean.refractive_index = 1.5195;
  lean.widest_mm = 40;
  return lean;
}

BlockTileOptions OptionsOf(std::optional<BeamLean> lean) {
  BlockTileOptions options;
  options.columns = 3;
  options.rows = 2;
  options.cone = BeamCone(kConeTangent);
  options.cone.lean = lean;
  return options;
}

/// Points that are fired through a crack of an earlier tile, each pair of points
/// compared.
std::uint64_t CountThroughEarlierTiles(const PointList& points_mm,
                                       const std::vector<BlockTile>& tiles,
                                       const BeamCone& cone) {
  std::uint64_t count = 0;
  for (std::size_t tile = 1; tile < tiles.size(); ++tile) {
    BeamCone own = cone;
    if (own.lean) own.lean->axis_mm = tiles[tile].axis_mm;
    for (const std::uint32_t point : tiles[tile].members) {
      const Vec3& apex = points_mm[point];
      const Vec2 lean = own.LeanAt(apex);
      bool through = false;
      for (std::size_t before = 0; before < tile && !through; ++before) {
        through = std::ranges::any_of(tiles[before].members, [&](std::uint32_t crack) {
          const Vec3 up = points_mm[crack] - apex;
          return up.z() > 0 &&
                 (up.head<2>() - up.z() * lean).norm() + 1e-9 < kConeTangent * up.z();
        });
      }
      count += through;
    }
  }
  return count;
}

double WidestReachMm(const PointList& points_mm, const std::vector<BlockTile>& tiles) {
  double reach_mm = 0;
  for (const BlockTile& tile : tiles) {
    for (const std::uint32_t point : tile.members) {
      const Vec2 from_axis = points_mm[point].head<2>() - tile.axis_mm;
      reach_mm = std::max(reach_mm, from_axis.cwiseAbs().maxCoeff());
    }
  }
  return reach_mm;
}

class BlockTilesOfLenses : public testing::TestWithParam<double> {};

TEST_P(BlockTilesOfLenses, FireNoPointThroughACrackOfAnEarlierTile) {
  const PointList points_mm = RandomBox(6000, kBlockMm, 5);
  const BlockTileOptions options = OptionsOf(
      std::isinf(GetParam()) ? std::optional<BeamLean>() : LeanFrom(GetParam()));
  const auto tiles = DivideIntoTiles(points_mm, options);
  EXPECT_EQ(tiles.size(), 6u);
  EXPECT_EQ(CountThroughEarlierTiles(points_mm, tiles, options.cone), 0u);
}

TEST_P(BlockTilesOfLenses, HaveEveryPointOnceAndInReach) {
  const PointList points_mm = RandomBox(30'000, kBlockMm, 6);
  const BlockTileOptions options = OptionsOf(
      std::isinf(GetParam()) ? std::optional<BeamLean>() : LeanFrom(GetParam()));
  const auto tiles = DivideIntoTiles(points_mm, options);
  std::vector<int> times(points_mm.size(), 0);
  for (const BlockTile& tile : tiles) {
    for (const std::uint32_t point : tile.members) ++times[point];
  }
  EXPECT_TRUE(std::ranges::all_of(times, [](int count) { return count == 1; }));
  // Half of a tile and the strip; and through the height of the block what the cone is
  // wider than it leans into its own tile, at the latest 1.5 mm inside of the seam.
  const double lean = (7.5 - 1.5) / (GetParam() * 1.5195);
  const double overhang_mm = kBlockMm.z() * std::max(0.0, kConeTangent - lean);
  EXPECT_LT(WidestReachMm(points_mm, tiles), 7.5 + options.strip_mm + overhang_mm);
}

TEST_P(BlockTilesOfLenses, MoveToANeighbourEachTime) {
  const auto tiles =
      DivideIntoTiles(RandomBox(3000, kBlockMm, 7),
                      OptionsOf(std::isinf(GetParam()) ? std::optional<BeamLean>()
                                                       : LeanFrom(GetParam())));
  for (std::size_t i = 1; i < tiles.size(); ++i) {
    const Vec2 move_mm = (tiles[i].axis_mm - tiles[i - 1].axis_mm).cwiseAbs();
    EXPECT_NEAR(move_mm.maxCoeff(), 15, 0.05) << i;  // a tile of the points' extent
    EXPECT_NEAR(move_mm.minCoeff(), 0, 1e-9) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Pupils, BlockTilesOfLenses,
                         testing::Values(140, 224,
                                         std::numeric_limits<double>::infinity()));

TEST(BlockTiles, WithoutTheirBeamsAreFiredThroughEarlierCracks) {
  // What the second rule is for: a telecentric lens over upright seams.
  const PointList points_mm = RandomBox(6000, kBlockMm, 5);
  BlockTileOptions options = OptionsOf(std::nullopt);
  options.cone = BeamCone(0);
  EXPECT_GT(CountThroughEarlierTiles(points_mm, DivideIntoTiles(points_mm, options),
                                     BeamCone(kConeTangent)),
            100u);
}

TEST(BlockTiles, AreMixedAlongASeam) {
  // A dense plate across one seam: in the strip both tiles have points at every stretch,
  // in equal parts at the seam itself.
  const PointList points_mm = RandomBox(40'000, {20, 20, 0.01}, 8);
  BlockTileOptions options;
  options.columns = 2;
  options.strip_mm = 0.5;
  const auto tiles = DivideIntoTiles(points_mm, options);
  ASSERT_EQ(tiles.size(), 2u);
  std::vector<int> left(20, 0), right(20, 0);
  for (std::size_t tile = 0; tile < 2; ++tile) {
    for (const std::uint32_t point : tiles[tile].members) {
      if (std::abs(points_mm[point].x() - 10) > 0.1) continue;
      const auto stretch = static_cast<std::size_t>(points_mm[point].y());
      ++(tile == 0 ? left : right).at(stretch);
    }
  }
  for (std::size_t stretch = 0; stretch < 20; ++stretch) {
    // 20 points; blue noise keeps both parts nearer to half than chance would.
    EXPECT_GE(left[stretch], 4) << stretch;
    EXPECT_GE(right[stretch], 4) << stretch;
  }
}

TEST(BlockTiles, OfDegenerateCloudsHaveEveryPoint) {
  for (const NamedCloud& cloud : DegenerateClouds()) {
    SCOPED_TRACE(cloud.name);
    std::size_t count = 0;
    for (const BlockTile& tile :
         DivideIntoTiles(cloud.points_mm, OptionsOf(std::nullopt))) {
      count += tile.members.size();
    }
    EXPECT_EQ(count, cloud.points_mm.size());
  }
}

}  // namespace
}  // namespace intaglio::sort
