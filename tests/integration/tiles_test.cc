// A block wider than the field of a scan head, in tiles: `intaglio tiles` makes a job for
// each, the processes engrave them one after another in the virtual glass head, and the
// cracks of all together are compared with the cloud, each at the place that tiles.csv
// states, without the product's proof.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using ::testing::HasSubstr;
using testing::Program;
using testing::RunJob;
using testing::Running;

const Vec3 kWideBlockMm(110, 56, 40);
constexpr double kWideMarginMm = 3, kLatticeMm = 4;
constexpr double kPartUnderHeadMm = 60;  // twice block_origin_mm of the profile
constexpr double kLengthOfCrackMm = 0.15;

struct TileRow {
  int points = 0;
  Vec2 corner_mm = Vec2::Zero(), move_mm = Vec2::Zero();
  fs::path job;
};

class TilesJob : public RunJob {
 protected:
  TilesJob() {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> jitter(-1, 1);
    std::ofstream cloud(folder_ / "cloud.xyz");
    cloud.precision(9);
    const Vec3 inner_mm = kWideBlockMm - Vec3::Constant(2 * kWideMarginMm);
    const Eigen::Vector3i counts = (inner_mm / kLatticeMm).cast<int>();
    for (int i = 0; i < counts.prod(); ++i) {
      const Vec3 cell(i % counts.x(), i / counts.x() % counts.y(),
                      i / (counts.x() * counts.y()));
      Vec3 point =
          Vec3::Constant(kWideMarginMm) + kLatticeMm * (cell + Vec3::Constant(0.5));
      for (double& coordinate : point) coordinate += jitter(random);
      points_mm_.push_back(point);
      cloud << point.transpose() << "\n";
    }
  }
  Ended MakeTiles(const std::string& machine, const std::string& width = "110") {
    Running run(
        Program("intaglio"),
        {"tiles", "--cloud", (folder_ / "cloud.xyz").string(), "--block", width, "56",
         "40", "--machine", machine, "--glass", "N-BK7", "--materials",
         (folder_ / "materials.db").string(), "--out", (folder_ / "tiles").string()},
        folder_ / "tiles.txt");
    return run.WaitForEnd(testing::kBound);
  }
  std::vector<TileRow> Rows() const {
    std::vector<TileRow> rows;
    std::istringstream text(testing::TextIn(folder_ / "tiles/tiles.csv"));
    std::string line;
    std::getline(text, line);
    EXPECT_EQ(line, "tile,points,corner_x_mm,corner_y_mm,move_x_mm,move_y_mm,job");
    while (std::getline(text, line)) {
      TileRow row;
      char job[64];
      int tile = 0;
      EXPECT_EQ(std::sscanf(line.c_str(), "%d,%d,%lf,%lf,%lf,%lf,%63s", &tile,
                            &row.points, &row.corner_mm.x(), &row.corner_mm.y(),
                            &row.move_mm.x(), &row.move_mm.y(), job),
                7)
          << line;
      row.job = folder_ / "tiles" / job;
      rows.push_back(row);
    }
    return rows;
  }

  PointList points_mm_;
};

TEST_F(TilesJob, MakesEveryPointOfAWideBlockOnceAndInItsPlace) {
  const Ended made = MakeTiles("galvo-glass");
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const auto rows = Rows();
  ASSERT_GE(rows.size(), 2u) << made.output;  // 102 mm of points, 54 mm of a part
  PointList cracks_mm;
  Vec2 corner_mm = rows.front().corner_mm;
  for (const TileRow& row : rows) {
    // Who moves the block by the moves alone comes to the same places.
    corner_mm += row.move_mm;
    EXPECT_NEAR((corner_mm - row.corner_mm).norm(), 0, 0.002);
    fs::remove_all(folder_ / "out");
    Running run(Program("intaglio"),
                Arguments({"--lockstep", "--warm-up", "0", "--no-record"}, row.job),
                folder_ / "output.txt");
    const Ended ended = run.WaitForEnd(testing::kBound);
    ASSERT_EQ(ended.exit_code, 0) << ended.output;
    EXPECT_EQ(Report().shadow_violations(), 0u);
    const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
    ASSERT_TRUE(glass.has_value());
    EXPECT_EQ(glass->cracks.size(), static_cast<std::size_t>(row.points));
    for (const auto& crack : glass->cracks) {
      Vec3 at_mm = crack.position_mm;
      at_mm.head<2>() -= Vec2::Constant(kPartUnderHeadMm / 2) + row.corner_mm;
      cracks_mm.push_back(at_mm);
    }
  }
  ASSERT_EQ(cracks_mm.size(), points_mm_.size());
  for (const Vec3& point : points_mm_) {
    // Points are 2 mm apart or more, so the nearest crack is its own.
    const auto nearest = std::ranges::min_element(
        cracks_mm, {}, [&](const Vec3& crack) { return (crack - point).squaredNorm(); });
    const Vec3 away_mm = *nearest - point;
    // 10 um, and a um of the rounding of tiles.csv.
    ASSERT_LT(away_mm.head<2>().cwiseAbs().maxCoeff(), 0.011) << point.transpose();
    ASSERT_LT(std::abs(away_mm.z()), kLengthOfCrackMm / 10) << point.transpose();
  }
}

TEST_F(TilesJob, RefusesAMachineWithoutMirrorsAndPointsOutsideTheBlock) {
  const Ended stage = MakeTiles("els-03");
  EXPECT_EQ(stage.exit_code, 2);
  EXPECT_THAT(stage.output, HasSubstr("tiles are for a scan head over the block"));
  const Ended narrow = MakeTiles("galvo-glass", "90");
  EXPECT_EQ(narrow.exit_code, 2);
  EXPECT_THAT(narrow.output, HasSubstr("give the --block that the cloud was made for"));
}

}  // namespace
}  // namespace intaglio
