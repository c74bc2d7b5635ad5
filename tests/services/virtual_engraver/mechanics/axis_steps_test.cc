// Axes that are set to whole steps, against whole numbers of nanometres and against the
// same axes without steps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "services/virtual_engraver/mechanics/mechanics.h"
#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

/// The multiple of a step that is nearest to a place, without a floating point number.
std::int64_t NearestNm(std::int64_t nm, std::int64_t step_nm) {
  std::int64_t below = nm / step_nm;
  if (nm % step_nm < 0) --below;
  const std::int64_t over_nm = nm - below * step_nm;
  return (below + (2 * over_nm > step_nm ? 1 : 0)) * step_nm;
}

// The resolutions of a planar drive (Trochimczuk 2008, table 5) at both ends, and none.
TEST(AxisSteps, AtRestAnAxisIsAtItsNearestStep) {
  StageOptions options = Roomy(0.0002);
  options.mechanics.steps_per_mm = Vec3(100, 100000, 0);
  Stage stage(options);
  std::uint64_t tick = 0;
  for (std::uint32_t run = 1; run <= 60; ++run) {
    const std::int32_t um = 1234 * (run % 2 == 0 ? -1 : 1) + 7 * static_cast<int>(run);
    link::Segments way =
        Frame({{Vec3(um, um, um), Vec3::Zero(), 20 * kTick, true, true}}, 0, run);
    // Not in the middle between two steps, where either is the nearest.
    const std::int32_t nm = 1000 * um + 170 * static_cast<int>(run) + 4 + 2 * (run % 2);
    way.segments[0].x_nm = way.segments[0].y_nm = way.segments[0].z_nm = nm;
    stage.BeginRun({run, tick + 1});
    stage.Append(way);
    for (int i = 0; i < 24; ++i) stage.AdvanceTick(kRateHz);
    tick += 24;
    ASSERT_FALSE(stage.running());
    const Vec3 place_mm = stage.place_mm();
    EXPECT_NEAR(place_mm.x() * 1e6, static_cast<double>(NearestNm(nm, 10000)), 1e-3);
    EXPECT_NEAR(place_mm.y() * 1e6, static_cast<double>(NearestNm(nm, 10)), 1e-3);
    EXPECT_NEAR(place_mm.z() * 1e6, nm, 1e-3) << "it has no steps";
    EXPECT_EQ(place_mm, stage.actual_mm()) << "its encoder sees it";
  }
}

TEST(AxisSteps, AJogEndsAtAStep) {
  StageOptions options = Roomy(0);
  options.mechanics.steps_per_mm = Vec3(80, 0, 0);
  Stage stage(options);
  stage.Jog({1'003'000, 1'003'000, 0, 20'000'000});
  for (int i = 0; i < 1000 && stage.jogging(); ++i) stage.AdvanceJog(0.01);
  stage.AdvanceTick(kRateHz);
  EXPECT_NEAR(stage.place_mm().x() * 1e6, 1'000'000, 1e-3) << "80 of 12.5 um";
  EXPECT_NEAR(stage.place_mm().y() * 1e6, 1'003'000, 1e-3);
}

// A lag of first order weighs what it is set to with a sum of one, so that it leaves no
// more than half a step; and steps to both sides leave no mean, as a delay would.
TEST(AxisSteps, InMotionAnAxisIsWithinHalfAStepAndNotLate) {
  constexpr double kStep_mm = 0.01;
  for (const double speed_mm_s : {0.03, 7.3, 83.1}) {
    MechanicsOptions options{0.0002};
    Mechanics smooth(options, Vec3::Zero());
    options.steps_per_mm = Vec3::Constant(1 / kStep_mm);
    Mechanics stepped(options, Vec3::Zero());
    const CubicCommand command = {Vec3::Constant(1e-7),
                                  speed_mm_s * Vec3(1, -0.77, 0.61)};
    double sum_mm = 0, max_mm = 0;
    int count = 0;
    for (double s = 0; s < 2; s += 0.00037, ++count) {
      smooth.Follow(command, s, s + 0.00037);
      stepped.Follow(command, s, s + 0.00037);
      const Vec3 beside_mm = stepped.actual_mm() - smooth.actual_mm();
      sum_mm += beside_mm.x();
      max_mm = std::max(max_mm, beside_mm.cwiseAbs().maxCoeff());
    }
    EXPECT_LE(max_mm, kStep_mm / 2 * (1 + 1e-9)) << speed_mm_s;
    EXPECT_GT(max_mm, kStep_mm / 10) << speed_mm_s;
    EXPECT_LT(std::abs(sum_mm / count), kStep_mm / 20) << speed_mm_s;
  }
}

// What the controller does not know of is in the error that its output compares.
TEST(AxisSteps, AStepBeyondTheToleranceHoldsThePulseBack) {
  for (const double steps_per_mm : {0.0, 100.0, 20.0}) {
    StageOptions options = Roomy(0);
    options.mechanics.steps_per_mm = Vec3(steps_per_mm, 0, 0);
    options.position_tolerance_mm = 0.01;
    Stage stage(options);
    stage.BeginRun({1, 1});
    stage.Append(Frame({{{1016, 0, 0}, {0, 0, 0}, 20 * kTick, true, true}}, 0, 1));
    bool in_position = false;
    for (int i = 0; i < 24; ++i) {
      stage.AdvanceTick(kRateHz);
      in_position = in_position || stage.in_position();
    }
    // 4 um beside it with steps of 10 um, 16 um with steps of 50 um.
    EXPECT_EQ(in_position, steps_per_mm != 20) << steps_per_mm;
  }
}

// A compare output fires where the axis comes nearest, and that is a step, too.
TEST(AxisSteps, TheCompareOutputIsAtASetPlace) {
  StageOptions options = Roomy(0);
  options.mechanics.steps_per_mm = Vec3(100, 0, 0);
  Stage stage(options);
  stage.BeginRun({1, 1});
  stage.Append(Frame({{{1016, 0, 0}, {0, 0, 0}, 20 * kTick, true, true}}, 0, 1));
  std::optional<Vec3> place_mm;
  for (int i = 0; i < 24 && !place_mm; ++i) {
    stage.AdvanceTick(kRateHz);
    place_mm = stage.PlaceOfCompare();
  }
  ASSERT_TRUE(place_mm.has_value());
  EXPECT_NEAR(place_mm->x(), 1.02, 1e-9);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
