// What ends a run of marks on a virtual grbl (mark_driver.h: K2 to K7).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/services/drivers/grbl/course_rig.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// K3: of each mark kBegun, then one end; in order.
void ExpectFatesInOrder(const std::vector<MarkEvent>& events) {
  std::optional<std::uint32_t> in_hand;
  std::int64_t newest = -1;
  for (const MarkEvent& event : events) {
    if (event.fate == MarkFate::kBegun) {
      ASSERT_FALSE(in_hand);
      ASSERT_GT(static_cast<std::int64_t>(event.mark), newest);
      newest = event.mark;
      in_hand = event.mark;
    } else if (event.fate == MarkFate::kNotBegun) {
      ASSERT_GT(static_cast<std::int64_t>(event.mark), newest);
    } else {
      ASSERT_EQ(in_hand, event.mark);
      in_hand.reset();
    }
  }
}

class GrblCourseStops : public ::testing::TestWithParam<CourseToolKind> {
 protected:
  GrblCourseStops()
      : rig_(GetParam()),
        pen_(GetParam() == COURSE_TOOL_LASER ? LaserPen() : MillPen()) {}
  /// In the middle of mark 2 of 6.
  void RunIntoMark() {
    ASSERT_TRUE(rig_.Ready()) << rig_.driver->state().message;
    const mark::MarkSet set = Squares(pen_, 6);
    ASSERT_TRUE(rig_.driver->Begin(1, set.pens));
    for (std::uint32_t i = 0; i < set.marks.size(); ++i)
      ASSERT_TRUE(rig_.driver->Append({i, set.marks[i]}));
    ASSERT_TRUE(rig_.driver->Finish());
    ASSERT_TRUE(rig_.StepUntil([&] { return rig_.LastOf(2) == MarkFate::kBegun; }));
    const auto at_work = [&] {
      return GetParam() == COURSE_TOOL_LASER ? rig_.lit()
                                             : rig_.seen.back().at_mm.z() < -0.1;
    };
    ASSERT_TRUE(rig_.StepUntil(at_work));
    rig_.StepFor(60ms);
  }
  bool Settle() {
    return rig_.StepUntil([&] { return rig_.driver->state().settled; });
  }
  void ExpectBrokenInMark() {
    EXPECT_EQ(rig_.LastOf(0), MarkFate::kDone);
    EXPECT_EQ(rig_.LastOf(1), MarkFate::kDone);
    EXPECT_EQ(rig_.LastOf(2), MarkFate::kBroken);
    for (std::uint32_t i = 3; i < 6; ++i) EXPECT_EQ(rig_.LastOf(i), MarkFate::kNotBegun);
    ExpectFatesInOrder(rig_.events);
  }
  /// The beam is off, or the spindle is, and nothing moves any more.
  void ExpectEnded() {
    EXPECT_FALSE(rig_.machine.grbl.spindle_on());
    const auto steps = rig_.machine.grbl.motion().steps_made();
    rig_.StepFor(500ms);
    EXPECT_EQ(rig_.machine.grbl.motion().steps_made(), steps);
    EXPECT_FALSE(rig_.lit());
  }
  void ExpectRunsAgain() {
    const mark::MarkSet set = Squares(pen_, 2);
    ASSERT_TRUE(rig_.StepUntil([&] {
      return rig_.driver->state().settled && rig_.driver->state().fault.empty();
    })) << rig_.driver->state().fault;
    ASSERT_TRUE(rig_.Run(2, set, 10)) << rig_.driver->state().fault;
    EXPECT_EQ(rig_.LastOf(11), MarkFate::kDone);
    EXPECT_EQ(rig_.early_count, 0U);
  }
  /// The controller may not know where its tool is.
  void ExpectRunsBehindAZeroAlone() {
    ASSERT_TRUE(rig_.StepUntil([&] {
      return rig_.driver->state().settled && rig_.driver->state().fault.empty();
    })) << rig_.driver->state().fault;
    EXPECT_THAT(rig_.driver->state().place_lost, HasSubstr("set it"));
    EXPECT_FALSE(rig_.driver->Begin(2, std::vector{pen_}));
    for (const std::array<bool, 3>& sets :
         {std::array{true, true, false}, std::array{false, false, true}}) {
      EXPECT_NE(rig_.driver->state().place_lost, "");
      ASSERT_TRUE(rig_.driver->hand()->SetZero(Vec3::Zero(), sets));
      ASSERT_TRUE(rig_.StepUntil([&] { return rig_.driver->hand()->state().at_rest; }));
    }
    EXPECT_EQ(rig_.driver->state().place_lost, "");
    ExpectRunsAgain();
  }

  CourseRig rig_;
  mark::Pen pen_;
};

TEST_P(GrblCourseStops, StopEndsTheMarkInHandAndKeepsThePlace) {
  RunIntoMark();
  ASSERT_TRUE(rig_.driver->Stop());
  ASSERT_TRUE(Settle());
  ExpectBrokenInMark();
  ExpectEnded();
  EXPECT_EQ(rig_.driver->state().fault, "") << "a hold before the reset loses no steps";
  EXPECT_EQ(rig_.machine.grbl.state(), grbl::VirtualGrbl::State::kIdle);
  ExpectRunsAgain();
}

TEST_P(GrblCourseStops, PauseEndsTheRunBehindTheMarkInHand) {
  RunIntoMark();
  ASSERT_TRUE(rig_.driver->Pause());
  ASSERT_TRUE(Settle());
  EXPECT_EQ(rig_.LastOf(2), MarkFate::kDone);
  EXPECT_EQ(rig_.LastOf(3), MarkFate::kNotBegun);
  EXPECT_EQ(rig_.CountOf(MarkFate::kBroken), 0U);
  ExpectFatesInOrder(rig_.events);
  ExpectEnded();
  ExpectRunsAgain();
}

TEST_P(GrblCourseStops, APermissionThatIsWithdrawnOrRunsOutIsAStop) {
  RunIntoMark();
  rig_.permits = false;
  const double from_us = rig_.machine.grbl.motion().now_us();
  ASSERT_TRUE(rig_.StepUntil([&] { return rig_.LastOf(2) == MarkFate::kBroken; }));
  // The rig's clock: 250 ms, or of a spindle the rest in the work; the braking, and a
  // reset.
  const double lease_us = GetParam() == COURSE_TOOL_LASER ? 250e3 : 2000e3;
  EXPECT_LT(rig_.machine.grbl.motion().now_us() - from_us, lease_us + 400e3);
  ASSERT_TRUE(Settle());
  ExpectBrokenInMark();
  ExpectEnded();
  rig_.permits = true;
  ExpectRunsAgain();
  ASSERT_TRUE(rig_.driver->Begin(3, std::vector{pen_}));
  ASSERT_TRUE(rig_.driver->Append({20, SquareAt(0, 0, 2)}));
  ASSERT_TRUE(rig_.StepUntil([&] { return rig_.moves(); }));
  rig_.permits = false;
  ASSERT_TRUE(rig_.driver->Permit(false));
  ASSERT_TRUE(Settle());
  EXPECT_EQ(rig_.LastOf(20), MarkFate::kBroken);
}

TEST_P(GrblCourseStops, ADoorEndsItAndIsCounted) {
  RunIntoMark();
  const auto before = rig_.driver->state().openings;
  rig_.machine.grbl.SetDoor(true);
  ASSERT_TRUE(rig_.StepUntil([&] { return rig_.LastOf(2) == MarkFate::kBroken; }));
  EXPECT_FALSE(rig_.driver->state().door_closed);
  EXPECT_EQ(rig_.driver->state().openings, before + 1);
  EXPECT_THAT(rig_.driver->state().fault, HasSubstr("the safety door opened"));
  EXPECT_TRUE(rig_.driver->state().safe_state);
  ExpectBrokenInMark();
  EXPECT_FALSE(rig_.driver->Reset()) << "the door is open";
  EXPECT_FALSE(rig_.driver->Begin(2, std::vector{pen_}));
  rig_.machine.grbl.SetDoor(false);
  rig_.StepFor(100ms);
  ExpectEnded();
  ASSERT_TRUE(rig_.driver->Reset());
  ExpectRunsAgain();
}

TEST_P(GrblCourseStops, AHoldAtTheMachineEndsIt) {
  RunIntoMark();
  rig_.machine.grbl.Write("!");
  ASSERT_TRUE(rig_.StepUntil([&] { return !rig_.driver->state().fault.empty(); }));
  EXPECT_THAT(rig_.driver->state().fault, HasSubstr("on hold"));
  ASSERT_TRUE(Settle());
  ExpectBrokenInMark();
  ASSERT_TRUE(rig_.driver->Reset());
  ExpectRunsAgain();
}

TEST_P(GrblCourseStops, ALimitIsAFaultUntilReset) {
  RunIntoMark();
  rig_.machine.grbl.HitLimit();
  ASSERT_TRUE(rig_.StepUntil([&] { return rig_.LastOf(2) == MarkFate::kBroken; }));
  ASSERT_TRUE(Settle());
  ExpectBrokenInMark();
  EXPECT_FALSE(rig_.driver->state().fault.empty());
  EXPECT_FALSE(rig_.driver->Begin(2, std::vector{pen_}));
  ASSERT_TRUE(rig_.driver->Reset());
  ExpectRunsBehindAZeroAlone();
}

TEST_P(GrblCourseStops, ALostLineLeavesLittleMotionAndOneUncertainMark) {
  RunIntoMark();
  rig_.machine.Cut(true);
  const double from_us = rig_.machine.grbl.motion().now_us();
  ASSERT_TRUE(rig_.StepUntil([&] { return !rig_.moves(); }));
  // What was sent ahead, at the speed asked for, and the braking at its end.
  EXPECT_LT(rig_.machine.grbl.motion().now_us() - from_us, 250e3);
  // What this family does not keep: a spindle turns on.
  EXPECT_EQ(rig_.lit(), GetParam() == COURSE_TOOL_SPINDLE);
  ASSERT_TRUE(rig_.StepUntil([&] { return !rig_.driver->state().link_up; }));
  EXPECT_FALSE(rig_.driver->state().settled);
  EXPECT_EQ(rig_.LastOf(2), MarkFate::kBegun) << "nobody knows its end";
  EXPECT_EQ(rig_.LastOf(3), MarkFate::kNotBegun);
  EXPECT_THAT(rig_.driver->state().fault, HasSubstr("lost in mark 2"));
  rig_.machine.Cut(false);
  ASSERT_TRUE(rig_.Ready());
  ASSERT_TRUE(rig_.driver->RequestPast(1, 1, 3));
  rig_.events.clear();
  rig_.Step();
  EXPECT_EQ(rig_.LastOf(1), MarkFate::kDone);
  EXPECT_EQ(rig_.LastOf(2), MarkFate::kUncertain);
  EXPECT_EQ(rig_.LastOf(3), MarkFate::kNotBegun);
  ExpectEnded();
  ASSERT_TRUE(rig_.driver->Reset());
  ExpectRunsAgain();
}

TEST_P(GrblCourseStops, AnotherHostKnowsNothingOfTheMarks) {
  RunIntoMark();
  const auto session = rig_.driver->state().session;
  rig_.MakeDriver();
  ASSERT_TRUE(rig_.Ready());
  EXPECT_FALSE(rig_.driver->state().remembers_marks);
  EXPECT_GE(rig_.driver->state().session + session, 2U);
  ExpectEnded();
  rig_.events.clear();
  ASSERT_TRUE(rig_.driver->RequestPast(1, 0, 6));
  rig_.Step();
  EXPECT_EQ(rig_.CountOf(MarkFate::kUncertain), 6U);
}

TEST_P(GrblCourseStops, APowerCutEndsTheSession) {
  RunIntoMark();
  const auto session = rig_.driver->state().session;
  const std::string power_up = rig_.driver->state().power_up;
  EXPECT_NE(power_up, "");
  rig_.machine.SwitchOff();
  rig_.StepFor(1s);
  EXPECT_FALSE(rig_.driver->state().link_up);
  rig_.machine.SwitchOn();
  ASSERT_TRUE(rig_.Ready());
  EXPECT_GT(rig_.driver->state().session, session);
  EXPECT_NE(rig_.driver->state().power_up, power_up);
  ASSERT_TRUE(rig_.driver->Reset());
  ExpectRunsBehindAZeroAlone();
}

INSTANTIATE_TEST_SUITE_P(Tools, GrblCourseStops,
                         ::testing::Values(COURSE_TOOL_LASER, COURSE_TOOL_SPINDLE));

// K3 and K6: wherever the line breaks, no mark is made twice, and what is reported done
// was made whole.
TEST(GrblCourseLine, WhereverTheLineBreaksAMarkThatIsDoneWasMade) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 12; ++trial) {
    CourseRig rig(COURSE_TOOL_LASER);
    ASSERT_TRUE(rig.Ready());
    const mark::MarkSet set = Squares(LaserPen(), 4);
    ASSERT_TRUE(rig.driver->Begin(1, set.pens));
    for (std::uint32_t i = 0; i < 4; ++i)
      ASSERT_TRUE(rig.driver->Append({i, set.marks[i]}));
    ASSERT_TRUE(rig.driver->Finish());
    rig.machine.CutAfter(std::uniform_int_distribution<std::uint64_t>(20, 1800)(random));
    rig.StepUntil([&] { return !rig.driver->state().link_up || !rig.moves(); });
    rig.StepFor(3s);
    ExpectFatesInOrder(rig.events);
    for (std::uint32_t i = 0; i < 4; ++i) {
      const double missed = FarthestMissed(set.marks[i], i, rig.seen,
                                           [](const SeenPlace& one) { return one.lit; });
      if (rig.LastOf(i) == MarkFate::kDone) {
        EXPECT_LE(missed, 0.021);
      }
      if (rig.LastOf(i) == MarkFate::kNotBegun) {
        EXPECT_GT(missed, 1e6);
      }
    }
  }
}

}  // namespace
}  // namespace intaglio::drivers
