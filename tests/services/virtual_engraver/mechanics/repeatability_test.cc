#include "services/virtual_engraver/mechanics/repeatability.h"

#include <gtest/gtest.h>

#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

/// Deviations of the places at which a stage of this repeatability rests after each of
/// some moves.
std::vector<Vec3> DeviationsMm(double repeatability_mm, unsigned seed) {
  StageOptions options = Roomy(0);
  options.repeatability_mm = repeatability_mm;
  options.repeatability_seed = seed;
  Stage stage(options);
  std::vector<Vec3> deviations_mm;
  std::uint64_t tick = 0;
  for (std::uint32_t run = 1; run <= 200; ++run) {
    stage.BeginRun({run, tick + 1});
    const double x_um = run % 2 == 0 ? 0 : 5000;
    stage.Append(Frame({{{x_um, 0, 0}, {0, 0, 0}, 20 * kTick, true, true}}, 0, run));
    for (int i = 0; i < 22; ++i) stage.AdvanceTick(kRateHz);
    tick += 22;
    EXPECT_FALSE(stage.running());
    EXPECT_EQ(stage.actual_mm(), Vec3(x_um / 1000, 0, 0)) << "the encoder sees nothing";
    deviations_mm.push_back(stage.place_mm() - stage.actual_mm());
  }
  return deviations_mm;
}

TEST(Repeatability, EveryPlaceThatIsGoneToDeviatesWithinItsBound) {
  const auto deviations_mm = DeviationsMm(0.01, 7);
  Vec3 min_mm = Vec3::Zero(), max_mm = Vec3::Zero();
  for (const Vec3& mm : deviations_mm) {
    min_mm = min_mm.cwiseMin(mm);
    max_mm = max_mm.cwiseMax(mm);
  }
  // None of 200 uniform draws is within a tenth of an end with 1e-9 probability.
  EXPECT_LE(max_mm.maxCoeff(), 0.01);
  EXPECT_GE(max_mm.minCoeff(), 0.008);
  EXPECT_GE(min_mm.minCoeff(), -0.01);
  EXPECT_LE(min_mm.maxCoeff(), -0.008);
  EXPECT_NE(deviations_mm[0], deviations_mm[2]) << "the same place, gone to twice";
}

TEST(Repeatability, TheSeedDecidesItAndZeroIsNone) {
  EXPECT_EQ(DeviationsMm(0.01, 7), DeviationsMm(0.01, 7));
  EXPECT_NE(DeviationsMm(0.01, 7), DeviationsMm(0.01, 8));
  for (const Vec3& mm : DeviationsMm(0, 7)) EXPECT_EQ(mm, Vec3(Vec3::Zero()));
}

TEST(Repeatability, ItGoesOverSmoothlyFromEndToEnd) {
  Repeatability repeatability(0.01, 3);
  repeatability.PassEnd();
  for (int end = 0; end < 50; ++end) {
    const Vec3 before = repeatability.DeviationMm(1);
    repeatability.PassEnd();
    EXPECT_LT((repeatability.DeviationMm(0) - before).norm(), 1e-15);
    // A smooth step of at most 0.02 mm is nowhere steeper than 1.5 times its mean.
    for (int i = 0; i < 100; ++i) {
      const Vec3 step = repeatability.DeviationMm((i + 1) / 100.0) -
                        repeatability.DeviationMm(i / 100.0);
      EXPECT_LE(step.cwiseAbs().maxCoeff(), 1.5 * 0.02 / 100 + 1e-12);
    }
    const Vec3 half = repeatability.DeviationMm(0.5);
    repeatability.LeaveAt(0.5);
    EXPECT_EQ(repeatability.DeviationMm(0), half);
  }
}

}  // namespace
}  // namespace intaglio::virtual_engraver
