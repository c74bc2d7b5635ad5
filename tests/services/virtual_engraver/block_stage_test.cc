// The stage that carries the block: how it moves, what the controller refuses, and where
// a crack comes to lie in the block. The oracle of places is the geometry, written here.

#include "services/virtual_engraver/block_stage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "services/virtual_engraver/positioner.h"
#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr std::int32_t kMmInNm = 1'000'000;  // nm
constexpr double kBlockStepS = 0.001;

StageOptions WithBlockStage() {
  StageOptions options = Roomy(0);
  options.block_stage = BlockStageOptions{Vec2(-60, -10), Vec2(60, 10), 40, 200};
  return options;
}

TEST(BlockStage, KeepsItsSpeedAndAccelerationAndEndsAtItsPlace) {
  Stage stage(WithBlockStage());
  stage.MoveBlock({-50 * kMmInNm, 10 * kMmInNm, 100 * kMmInNm});
  EXPECT_FALSE(stage.Report().at_rest);
  Vec2 before_mm = stage.block_mm(), before_mm_s = Vec2::Zero();
  double fastest_mm_s = 0;
  int steps = 0;
  for (; stage.jogging() && steps < 10000; ++steps) {
    stage.AdvanceJog(kBlockStepS);
    const Vec2 speed_mm_s = (stage.block_mm() - before_mm) / kBlockStepS;
    EXPECT_LE((speed_mm_s - before_mm_s).norm() / kBlockStepS, 200 * 1.001) << steps;
    fastest_mm_s = std::max(fastest_mm_s, speed_mm_s.norm());
    before_mm = stage.block_mm();
    before_mm_s = speed_mm_s;
  }
  EXPECT_NEAR(fastest_mm_s, 40, 1e-6);
  EXPECT_NEAR((stage.block_mm() - Vec2(-50, 10)).norm(), 0, 1e-9);
  // 51 mm at 40 mm/s, and 0.2 s more of both ramps.
  EXPECT_NEAR(steps * kBlockStepS, std::hypot(50, 10) / 40 + 0.2, 2 * kBlockStepS);
  const link::MotionStatus status = stage.Report();
  EXPECT_TRUE(status.at_rest);
  EXPECT_EQ(status.block_x_nm, -50 * kMmInNm);
  EXPECT_EQ(status.block_y_nm, 10 * kMmInNm);
  EXPECT_EQ(status.jogs_taken, 1u);
  EXPECT_EQ(stage.actual_mm(), Vec3::Zero());
}

TEST(BlockStage, IsAskedForByEachRunAndEndsOneThatItLeaves) {
  Stage stage(WithBlockStage());
  EXPECT_TRUE(stage.Identity().moves_block);
  stage.BeginRun({1, kStartTick, 20'000, 0});
  EXPECT_EQ(stage.fault(), link::StageFault::kBlockPlace);
  EXPECT_FALSE(stage.running());
  stage.Reset();
  // Within the tolerance of 10 um.
  stage.BeginRun({2, kStartTick, 9'000, 0});
  stage.Append(Frame(kPath, 0, 2));
  for (std::uint64_t tick = 0; tick <= kStartTick + 1; ++tick) stage.AdvanceTick(kRateHz);
  EXPECT_TRUE(stage.running());
  stage.MoveBlock({10 * kMmInNm, 0, kMmInNm});
  EXPECT_EQ(stage.block_mm(), Vec2::Zero()) << "it moves in a run";
  stage.PushBlock({0, 0.5});
  EXPECT_EQ(stage.fault(), link::StageFault::kBlockPlace);
  for (int tick = 0; tick < 20; ++tick) {
    stage.AdvanceTick(kRateHz);
    EXPECT_FALSE(stage.in_position());
  }
  EXPECT_FALSE(stage.running());
}

TEST(BlockStage, BrakesForAnAbortAndStaysWithinItsTravel) {
  Stage stage(WithBlockStage());
  stage.MoveBlock({61 * kMmInNm, 0, 40 * kMmInNm});
  EXPECT_EQ(stage.fault(), link::StageFault::kLimit);
  EXPECT_TRUE(stage.Report().at_rest);
  stage.Reset();
  stage.MoveBlock({60 * kMmInNm, 0, 40 * kMmInNm});
  stage.AdvanceJog(0.5);
  const double from_mm = stage.block_mm().x();
  stage.BeginRun({1, kStartTick, 0, 0});
  EXPECT_EQ(stage.fault(), link::StageFault::kRunRefused);
  stage.AdvanceJog(5);
  EXPECT_TRUE(stage.Report().at_rest);
  EXPECT_NEAR(stage.block_mm().x() - from_mm, 40.0 * 40 / (2 * 200), 1e-6);
  Stage without(Roomy(0));
  EXPECT_FALSE(without.Identity().moves_block);
  without.MoveBlock({kMmInNm, 0, kMmInNm});
  EXPECT_TRUE(without.Report().at_rest);
  without.BeginRun({1, kStartTick, kMmInNm, 0});
  EXPECT_EQ(without.fault(), link::StageFault::kBlockPlace);
}

// The block goes by 10 and 20 mm along carriages that are turned by 2 and -3 mrad, of
// which the first goes 1 % too far: the focus stays, so in the block it goes back.
TEST(BlockStage, CarriesTheBlockUnderTheBeam) {
  PositionerOptions positioner;
  positioner.has_mirrors = true;
  positioner.block_guides[0].travel_ratio = 1.01;
  positioner.block_guides[0].turn_rad = 0.002;
  positioner.block_guides[1].turn_rad = -0.003;
  const Vec3 axes(3, -4, 5);
  const Vec2 along_x(std::cos(0.002), std::sin(0.002)),
      along_y(std::sin(0.003), std::cos(0.003));
  const Vec2 moved_mm = 10 * 1.01 * along_x + 20 * along_y;
  const Vec3 at_mm = FocusAt(positioner, axes, Vec2(10, 20));
  EXPECT_NEAR((at_mm.head<2>() - (axes.head<2>() - moved_mm)).norm(), 0, 1e-12);
  EXPECT_EQ(at_mm.z(), axes.z());
}

}  // namespace
}  // namespace intaglio::virtual_engraver
