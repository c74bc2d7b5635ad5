// The axis z of a BJJCZ board that is homed: its place is known behind an origin that was
// found, and behind nothing else.

#include <gtest/gtest.h>

#include <functional>

#include "tests/services/drivers/bjjcz/point_rig.h"

namespace intaglio::drivers {
namespace {

/// In its travel, 51 mm above the origin; no fault.
class Axis {
 public:
  Axis()
      : machine(false, true),
        driver(MakeBjjczPointDriverAt(machine, BjjczPointProfile())) {}

  void StepFor(int ms) {
    for (int i = 0; i < ms; ++i) {
      machine.Advance();
      driver->laser()->Poll([](const link::PulseReport&) {},
                            [](const link::PastReport&) {});
    }
  }
  bool Until(const std::function<bool()>& condition, int limit_ms = 60000) {
    for (int i = 0; i < limit_ms && !condition(); ++i) StepFor(1);
    return condition();
  }
  void Connect() {
    ASSERT_TRUE(Until([&] { return driver->laser()->up(); }));
    ASSERT_TRUE(driver->laser()->Reset() && driver->ClearFault());
    StepFor(50);
  }

  BjjczMachine machine;
  std::unique_ptr<MotionDriver> driver;
};

// At every step on the way of its command, and in the search for the origin.
TEST(BjjczHome, AHomeThatIsLetGoRestsThereAndLeavesNoPlace) {
  for (const int steps : {0, 1, 2, 3, 5, 8, 13, 200, 400}) {
    Axis axis;
    axis.Connect();
    ASSERT_TRUE(axis.driver->Home()) << axis.driver->state().message;
    axis.StepFor(steps);
    ASSERT_TRUE(axis.driver->Hold());
    ASSERT_TRUE(axis.Until([&] { return axis.driver->state().at_rest; }, 3000)) << steps;
    const double rest = axis.machine.board.axis();
    ASSERT_GT(rest, 0) << "it has come to its origin";
    axis.StepFor(2000);
    EXPECT_EQ(axis.machine.board.axis(), rest) << steps;
    EXPECT_NEAR(axis.driver->state().position_mm.z(), rest / kBoardStepsPerMm - 51, 1e-9);
    const bool is_known = FindHindrance(axis.driver->state()) == MotionHindrance();
    EXPECT_EQ(is_known, steps == 0) << steps;
    ASSERT_TRUE(axis.driver->Home()) << axis.driver->state().message;
    EXPECT_TRUE(axis.Until([&] { return axis.driver->state().at_rest; }));
    EXPECT_EQ(FindHindrance(axis.driver->state()), MotionHindrance());
    EXPECT_NEAR(axis.driver->state().position_mm.z(), -50, 1e-9);
  }
}

// A switch that is worn, or turned by hand in the search.
TEST(BjjczHome, AnOriginThatWasNotFoundIsNoPlaceAndIsNotDrivenFrom) {
  Axis axis;
  axis.Connect();
  ASSERT_TRUE(axis.driver->Home()) << axis.driver->state().message;
  ASSERT_TRUE(axis.Until([&] { return axis.machine.board.moves(); }));
  axis.machine.board.SetAxis(1234);
  ASSERT_TRUE(axis.Until(
      [&] { return axis.driver->state().fault == intaglio_MOTION_FOLLOWING_ERROR; }));
  axis.StepFor(2000);
  EXPECT_EQ(axis.machine.board.axis(), 1234);
  EXPECT_FALSE(axis.driver->state().homed);
}

TEST(BjjczHome, APlaceThatIsLostIsNotKnownAgainWhenTheLineIsBack) {
  for (const bool searches : {true, false}) {
    Axis axis;
    axis.Connect();
    const Vec3 up_mm = axis.driver->state().position_mm + Vec3(0, 0, 5);
    ASSERT_TRUE(searches ? axis.driver->Home() : axis.driver->Jog(up_mm, 20));
    ASSERT_TRUE(axis.Until([&] { return axis.machine.board.moves(); }));
    if (!searches) {
      // Its limit switch.
      axis.machine.board.SetAxis(static_cast<std::int32_t>(axis.machine.board.axis()));
      ASSERT_TRUE(axis.Until([&] {
        return axis.driver->state().fault == intaglio_MOTION_FOLLOWING_ERROR;
      })) << axis.driver->state().message;
    }
    axis.machine.Cut(true);
    axis.StepFor(600);
    axis.machine.Cut(false);
    axis.Connect();
    EXPECT_NE(axis.machine.board.axis(), 0);
    EXPECT_EQ(FindHindrance(axis.driver->state()).fault, intaglio_MOTION_PLACE_LOST);
  }
}

}  // namespace
}  // namespace intaglio::drivers
