#include "services/virtual_engraver/mechanics/backlash.h"

#include <gtest/gtest.h>

#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

// By hand, with a play of 0.2 on x: what is carried is taken along by either end of it.
TEST(Backlash, CarriesWhenThePlayIsCrossed) {
  Backlash backlash(Vec3(0.2, 0, 0), Vec3::Zero());
  const auto at = [&](double x_mm) {
    backlash.Follow(Vec3(x_mm, x_mm, 0));
    EXPECT_EQ(backlash.carried_mm().y(), x_mm) << "no play on y";
    return backlash.carried_mm().x();
  };
  EXPECT_DOUBLE_EQ(at(0.05), 0);
  EXPECT_DOUBLE_EQ(at(1), 0.9);
  EXPECT_DOUBLE_EQ(at(0.85), 0.9);
  EXPECT_DOUBLE_EQ(at(0.8), 0.9);
  EXPECT_DOUBLE_EQ(at(0.5), 0.6);
  EXPECT_DOUBLE_EQ(at(0.6), 0.6);
  EXPECT_DOUBLE_EQ(at(3), 2.9);
}

// A place that is gone to from below and from above differs by the play, whatever turns
// the way to it has; the encoder does not see it.
TEST(Backlash, OfAStageIsBetweenBothApproaches) {
  StageOptions options = Roomy(0);
  options.backlash_mm = Vec3(0.02, 0, 0);
  Stage stage(options);
  std::uint64_t tick = 0;
  std::uint32_t run = 0;
  const auto go = [&](double x_um) {
    stage.BeginRun({++run, tick + 1});
    stage.Append(Frame({{{x_um, 0, 0}, {0, 0, 0}, 20 * kTick, true, true}}, 0, run));
    for (int i = 0; i < 22; ++i) stage.AdvanceTick(kRateHz);
    tick += 22;
    EXPECT_EQ(stage.actual_mm().x(), x_um / 1000);
    return stage.place_mm().x() - x_um / 1000;
  };
  EXPECT_NEAR(go(5000), -0.01, 1e-12);
  EXPECT_NEAR(go(9000), -0.01, 1e-12);
  EXPECT_NEAR(go(5000), 0.01, 1e-12);
  EXPECT_NEAR(go(4990), 0.01, 1e-12);
  EXPECT_NEAR(go(4995), 0.005, 1e-12) << "within the play";
  EXPECT_NEAR(go(6000), -0.01, 1e-12);
}

// It goes beyond within one segment and comes back: a turn between two ticks counts.
TEST(Backlash, ATurnWithinASegmentCounts) {
  StageOptions options = Roomy(0);
  options.backlash_mm = Vec3(0.02, 0, 0);
  Stage stage(options);
  stage.BeginRun({1, 1});
  // Arrives at rest at 1 mm, coming from above: begins fast, ends at rest.
  stage.Append(Frame({{{900, 0, 0}, {20000, 0, 0}, 10 * kTick, false, false},
                      {{1000, 0, 0}, {0, 0, 0}, 10 * kTick, true, true}},
                     0, 1));
  for (int i = 0; i < 30; ++i) stage.AdvanceTick(kRateHz);
  EXPECT_EQ(stage.actual_mm().x(), 1.0);
  EXPECT_NEAR(stage.place_mm().x(), 1.01, 1e-9);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
