// Motion by hand and the work zero of a mill and of a laser on a virtual grbl: M14 to M16
// of motion_driver.h, by the tool's own way.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/services/drivers/grbl/course_rig.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class GrblCourseByHand : public ::testing::TestWithParam<CourseToolKind> {
 protected:
  GrblCourseByHand() : rig_(GetParam()) {}
  HandMotion& hand() { return *rig_.driver->hand(); }
  Vec3 at() const { return rig_.machine.grbl.motion().Position_mm(); }
  bool Rests() {
    return rig_.StepUntil([&] { return hand().state().at_rest; });
  }
  mark::Pen pen() const {
    return GetParam() == COURSE_TOOL_LASER ? LaserPen() : MillPen();
  }
  CourseRig rig_;
};

TEST_P(GrblCourseByHand, AJogGoesToItsPlaceAtItsSpeedWithoutBeamOrSpindle) {
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().Jog({6, -8, 2}, 20));
  EXPECT_FALSE(hand().state().at_rest);
  const double begin_us = rig_.machine.grbl.motion().now_us();
  double fastest_mm_s = 0;
  ASSERT_TRUE(rig_.StepUntil([&] {
    fastest_mm_s = std::max(fastest_mm_s, rig_.machine.grbl.motion().speed_mm_s());
    EXPECT_FALSE(rig_.machine.grbl.spindle_on() || rig_.lit());
    return hand().state().at_rest;
  }));
  EXPECT_LT((at() - Vec3(6, -8, 2)).norm(), 1e-3);
  EXPECT_LT((hand().state().position_mm - Vec3(6, -8, 2)).norm(), 1e-3);
  EXPECT_LE(fastest_mm_s, 20 + 1e-6);
  const double way_mm = Vec3(6, -8, 2).norm();
  EXPECT_GE(rig_.machine.grbl.motion().now_us() - begin_us, 1e6 * way_mm / 20);
  EXPECT_TRUE(rig_.machine.grbl.powers().empty());
}

TEST_P(GrblCourseByHand, HoldEndsAJogAndItDoesNotGoOn) {
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().Jog({45, 0, 0}, 50));
  ASSERT_TRUE(rig_.StepUntil([&] { return at().x() > 5; }));
  const double from_mm = at().x();
  ASSERT_TRUE(hand().Hold());
  ASSERT_TRUE(Rests());
  // The line's delay, and braking from 50 mm/s with 1000 mm/s2.
  EXPECT_LT(at().x() - from_mm, 50 * 0.02 + 1.25 + 0.5);
  const auto steps = rig_.machine.grbl.motion().steps_made();
  rig_.StepFor(2s);
  EXPECT_EQ(rig_.machine.grbl.motion().steps_made(), steps);
  EXPECT_EQ(hand().state().fault, intaglio_MOTION_OK);
}

// At any instant of it, also at the one of a line that is on its way: grbl is idle then,
// and nothing else says so.
TEST_P(GrblCourseByHand, AHoldAtTheControllerEndsAJogUntilTheFaultIsCleared) {
  for (int wait_ms = 60; wait_ms < 160; ++wait_ms) {
    CourseRig rig(GetParam());
    HandMotion& hand = *rig.driver->hand();
    ASSERT_TRUE(rig.Ready());
    ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
    ASSERT_TRUE(hand.Jog({45, 0, 0}, 20));
    const auto x = [&] { return rig.machine.grbl.motion().Position_mm().x(); };
    rig.StepFor(std::chrono::milliseconds(wait_ms));
    const double from_mm = x();
    const std::uint32_t openings = rig.driver->state().openings;
    rig.machine.grbl.PressHold();
    rig.StepFor(500ms);
    ASSERT_FALSE(rig.moves()) << wait_ms;
    EXPECT_LT(x() - from_mm, 20 * GrblCourseHand::kAhead_s) << wait_ms;
    EXPECT_EQ(hand.state().fault, intaglio_MOTION_SAFE_STATE) << wait_ms;
    EXPECT_THAT(hand.state().message, HasSubstr("hold"));
    EXPECT_EQ(rig.driver->state().openings, openings + 1) << wait_ms;
    EXPECT_FALSE(hand.Jog({0, 0, 0}, 20));
    const double rests_mm = x();
    ASSERT_TRUE(hand.ClearFault());
    rig.StepFor(500ms);
    EXPECT_EQ(x(), rests_mm) << "a cleared fault moves nothing";
    ASSERT_TRUE(hand.Jog({0, 0, 0}, 50)) << hand.state().message;
    ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
    EXPECT_LT(std::abs(x()), 1e-3) << wait_ms;
  }
}

// The reset's input of grbl 1.1 is obeyed once, when it closes, and no more while it is
// held: what the host sends would move the tool under the pressed button.
TEST_P(GrblCourseByHand, NothingMovesOrIsUnlockedWhileTheEmergencyStopIsPressed) {
  const CourseRig::Change is_hal = [](auto& options) { options.hal = true; };
  for (const CourseRig::Change change : {is_hal, CourseRig::Change(nullptr)}) {
    CourseRig rig(GetParam(), "", change);
    HandMotion& hand = *rig.driver->hand();
    ASSERT_TRUE(rig.Ready());
    ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
    const std::uint32_t openings = rig.driver->state().openings;
    rig.machine.grbl.SetEmergencyStop(true);
    rig.StepFor(500ms);
    EXPECT_TRUE(rig.driver->state().key_on && rig.driver->state().door_closed);
    EXPECT_FALSE(rig.driver->state().stop_released);
    EXPECT_GT(rig.driver->state().openings, openings);
    const auto steps = rig.machine.grbl.motion().steps_made();
    EXPECT_FALSE(rig.driver->Reset());
    EXPECT_FALSE(hand.ClearFault());
    EXPECT_THAT(hand.Jog({5, 0, 0}, 20).error().message, HasSubstr("emergency stop"));
    rig.StepFor(500ms);
    EXPECT_EQ(rig.machine.grbl.motion().steps_made(), steps);
    EXPECT_FALSE(rig.driver->Begin(1, std::vector{pen()}));

    rig.machine.grbl.SetEmergencyStop(false);
    rig.StepFor(500ms);
    EXPECT_TRUE(rig.driver->state().stop_released);
    EXPECT_EQ(rig.machine.grbl.motion().steps_made(), steps) << "it went on by itself";
    ASSERT_TRUE(hand.ClearFault());
    rig.StepFor(500ms);
    ASSERT_TRUE(hand.Jog({5, 0, 0}, 20)) << hand.state().message;
    ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
    EXPECT_LT((rig.machine.grbl.motion().Position_mm() - Vec3(5, 0, 0)).norm(), 1e-3);
  }
}

TEST_P(GrblCourseByHand, ALostLineLeavesWhatWasSentAhead) {
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().Jog({45, 0, 0}, 20));
  ASSERT_TRUE(rig_.StepUntil([&] { return at().x() > 3; }));
  rig_.machine.Cut(true);
  const double from_us = rig_.machine.grbl.motion().now_us();
  ASSERT_TRUE(rig_.StepUntil([&] { return !rig_.moves(); }));
  EXPECT_LT(rig_.machine.grbl.motion().now_us() - from_us, 250e3);
  rig_.StepFor(500ms);
  EXPECT_FALSE(hand().state().link_up);
  EXPECT_FALSE(hand().Jog({0, 0, 0}, 20));
  const Vec3 rests = at();
  rig_.machine.Cut(false);
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  EXPECT_EQ(at(), rests) << "it goes on by itself";
}

TEST_P(GrblCourseByHand, ARunAndMotionByHandExcludeEachOther) {
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().Jog({10, 0, 0}, 20));
  rig_.StepFor(100ms);
  EXPECT_FALSE(rig_.driver->state().settled);
  EXPECT_FALSE(rig_.driver->Begin(1, std::vector{pen()}));
  EXPECT_FALSE(hand().Jog({0, 0, 0}, 20)) << "one at a time";
  EXPECT_FALSE(hand().SetZero({0, 0, 0}, {true, true, true}));
  ASSERT_TRUE(Rests());
  rig_.Step();
  ASSERT_TRUE(rig_.driver->Begin(1, std::vector{pen()}));
  ASSERT_TRUE(rig_.driver->Append({0, SquareAt(0, 0, 2)}));
  ASSERT_TRUE(rig_.driver->Finish());
  rig_.Step();
  EXPECT_FALSE(hand().Jog({0, 0, 0}, 20));
  EXPECT_FALSE(hand().SetZero({0, 0, 0}, {true, true, true}));
  ASSERT_TRUE(rig_.StepUntil([&] { return rig_.LastOf(0) == MarkFate::kDone; }));
}

// What it reads at once may begin with a status from before the zero.
TEST_P(GrblCourseByHand, APlaceFromBeforeTheWorkZeroIsNotThatOfABusyHost) {
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().Jog({12, 7, -3}, 50));
  ASSERT_TRUE(Rests());
  for (int stall_ms = 1; stall_ms <= 120; ++stall_ms) {
    const double height_mm = 0.1 * stall_ms;
    ASSERT_TRUE(hand().SetZero({0, 0, height_mm}, {false, false, true}));
    ASSERT_TRUE(rig_.StepUntil([&] {
      for (int i = 0; i < stall_ms; ++i) rig_.machine.Advance();
      return hand().state().at_rest;
    }));
    EXPECT_NEAR(hand().state().position_mm.z(), height_mm, 1e-3) << stall_ms << " ms";
  }
}

// A run right behind it: what the driver sends is of the new zero.
TEST_P(GrblCourseByHand, TheWorkZeroIsWhereTheToolIs) {
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().Jog({12, 7, -3}, 50));
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().SetZero({0, 0, 0}, {true, true, false}));
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().SetZero({0, 0, 1}, {false, false, true}));
  ASSERT_TRUE(Rests());
  EXPECT_LT((at() - Vec3(12, 7, -3)).norm(), 1e-3) << "it moves";
  EXPECT_LT((hand().state().position_mm - Vec3(0, 0, 1)).norm(), 1e-3);
  const mark::MarkSet set{{pen()}, {SquareAt(1, 2, 2)}};
  rig_.seen.clear();
  ASSERT_TRUE(rig_.Run(1, set));
  Box3 work{Vec3::Constant(1e9), Vec3::Constant(-1e9)};
  for (const SeenPlace& one : rig_.seen) {
    const bool works = GetParam() == COURSE_TOOL_LASER ? one.lit : one.at_mm.z() < -1e-3;
    if (!works) continue;
    work.min_mm = work.min_mm.cwiseMin(one.at_mm);
    work.max_mm = work.max_mm.cwiseMax(one.at_mm);
  }
  // Seen every millisecond, at 20 mm/s.
  EXPECT_LT((work.min_mm.head<2>() - Vec2(1, 2)).norm(), 0.03);
  EXPECT_LT((work.max_mm.head<2>() - Vec2(3, 4)).norm(), 0.03);
  const Vec3 zero = at() - rig_.machine.grbl.WorkPosition_mm();
  EXPECT_LT((zero - Vec3(12, 7, -4)).norm(), 1e-3);
}

TEST_P(GrblCourseByHand, AnOpenDoorEndsAJogUntilTheFaultIsCleared) {
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  ASSERT_TRUE(hand().Jog({45, 0, 0}, 20));
  ASSERT_TRUE(rig_.StepUntil([&] { return at().x() > 3; }));
  rig_.machine.grbl.SetDoor(true);
  ASSERT_TRUE(rig_.StepUntil([&] { return !rig_.moves(); }));
  rig_.StepFor(200ms);
  EXPECT_THAT(hand().state().message, HasSubstr("door"));
  EXPECT_FALSE(hand().Jog({0, 0, 0}, 20));
  const Vec3 rests = at();
  rig_.machine.grbl.SetDoor(false);
  rig_.StepFor(1s);
  EXPECT_EQ(at(), rests);
  ASSERT_TRUE(hand().ClearFault());
  ASSERT_TRUE(rig_.StepUntil(
      [&] { return hand().state().fault == intaglio_MOTION_OK && Rests(); }));
  EXPECT_EQ(at(), rests) << "a cleared fault moves nothing";
  ASSERT_TRUE(hand().Jog({0, 0, 0}, 20));
  ASSERT_TRUE(Rests());
  EXPECT_LT(at().norm(), 1e-3);
}

TEST_P(GrblCourseByHand, WhatIsNoPlaceIsRefused) {
  EXPECT_FALSE(hand().Jog({1, 0, 0}, 20)) << "the line is down";
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(Rests());
  EXPECT_FALSE(hand().Jog({std::nan(""), 0, 0}, 20));
  EXPECT_FALSE(hand().Jog({1, 0, 0}, 0));
  EXPECT_FALSE(hand().SetZero({0, 0, 0}, {false, false, false}));
  EXPECT_THAT(hand().Home().error().message, HasSubstr("$22 is 0"));
  EXPECT_TRUE(hand().Hold());
  EXPECT_EQ(rig_.machine.grbl.motion().steps_made(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Of, GrblCourseByHand,
                         ::testing::Values(COURSE_TOOL_LASER, COURSE_TOOL_SPINDLE),
                         [](const auto& one) {
                           return one.param == COURSE_TOOL_LASER ? "laser" : "spindle";
                         });

TEST(GrblCourseHome, AControllerWithSwitchesIsHomedBeforeItIsMoved) {
  CourseRig rig(COURSE_TOOL_SPINDLE, "", [](grbl::VirtualGrblOptions& options) {
    options.homing = true;
    options.home_steps = {-50000, -30000, 20000};
  });
  ASSERT_TRUE(rig.StepUntil([&] { return rig.driver->state().link_up; }));
  rig.StepFor(500ms);
  HandMotion& hand = *rig.driver->hand();
  EXPECT_FALSE(hand.state().homed);
  EXPECT_EQ(hand.state().fault, intaglio_MOTION_OK) << hand.state().message;
  EXPECT_THAT(hand.Jog({1, 0, 0}, 20).error().message, HasSubstr("home it"));
  ASSERT_TRUE(hand.Home());
  rig.StepFor(50ms);
  EXPECT_FALSE(hand.state().at_rest);
  ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
  EXPECT_TRUE(hand.state().homed);
  EXPECT_EQ(rig.driver->state().fault, "");
  EXPECT_EQ(rig.machine.grbl.TrueSteps(), (grbl::Steps{-50000, -30000, 20000}));
  ASSERT_TRUE(hand.Jog({1, 1, -1}, 20)) << hand.state().message;
  ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
  EXPECT_LT((rig.machine.grbl.motion().Position_mm() - Vec3(1, 1, -1)).norm(), 1e-3);
}

TEST(GrblCourseHome, AJogBeyondTheSoftLimitsIsRefusedByTheController) {
  CourseRig rig(COURSE_TOOL_SPINDLE, "", [](grbl::VirtualGrblOptions& options) {
    options.soft_limits = true;
    options.travel_max_mm = Vec3::Constant(5);
  });
  ASSERT_TRUE(rig.Ready());
  HandMotion& hand = *rig.driver->hand();
  ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
  ASSERT_TRUE(hand.Jog({20, 0, 0}, 20));
  ASSERT_TRUE(rig.StepUntil([&] { return hand.state().fault != intaglio_MOTION_OK; }));
  EXPECT_THAT(hand.state().message, HasSubstr("refused"));
  ASSERT_TRUE(rig.StepUntil([&] { return !rig.moves() && hand.state().at_rest; }));
  EXPECT_LE(rig.machine.grbl.motion().Position_mm().x(), 5);
  ASSERT_TRUE(hand.ClearFault());
  rig.Step();
  ASSERT_TRUE(hand.Jog({0, 0, 0}, 20)) << hand.state().message;
  ASSERT_TRUE(rig.StepUntil([&] { return hand.state().at_rest; }));
  EXPECT_EQ(rig.driver->state().fault, "");
}

}  // namespace
}  // namespace intaglio::drivers
