// The driver of marks on a virtual grbl: its path against the marks' own chords, and what
// it refuses (mark_driver.h: K1, K2, K8).

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "services/drivers/mark_drivers.h"
#include "tests/services/drivers/grbl/course_rig.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// Arcs of both directions, of more and of less than half a circle; and an open one.
mark::MarkSet Curves(const mark::Pen& pen) {
  mark::MarkSet set{{pen}, {}};
  mark::Mark lens;
  lens.closed = true;
  lens.places = {{{0, 0}, 0.7}, {{3, 0.5}, -0.3}, {{4, 3}, 1.8}, {{1, 4}, 0}};
  mark::Mark circle;
  circle.closed = true;
  circle.places = {{{12, 2}, 1}, {{8, 2}, 1}};
  mark::Mark open;
  open.places = {{{-5, -5}}, {{-2, -5}, -1.2}, {{-2, -2}}, {{-6.1234, -3.3}}};
  set.marks = {lens, circle, open, SquareAt(5, -6, 2)};
  return set;
}

// grbl's arcs are chords within $12 = 0.001 mm, of which it rounds the number down;
// places are printed to 0.1 um and are steps of 0.1 um.
constexpr double kPathTolerance_mm = 0.002;

TEST(GrblCourse, TheBeamFollowsTheMarksAndNothingElse) {
  CourseRig rig(COURSE_TOOL_LASER);
  ASSERT_TRUE(rig.Ready()) << rig.driver->state().message;
  const mark::MarkSet set = Curves(LaserPen());
  ASSERT_TRUE(rig.Run(1, set)) << rig.driver->state().fault;
  EXPECT_EQ(rig.CountOf(MarkFate::kDone), set.marks.size());
  std::size_t lit = 0;
  for (const SeenPlace& one : rig.seen) {
    if (!one.lit) continue;
    ++lit;
    ASSERT_TRUE(one.in_hand);
    ASSERT_LE(DistanceToMark(one.at_mm.head<2>(), set.marks[one.mark]),
              kPathTolerance_mm);
  }
  EXPECT_GT(lit, 1000U);
  // 20 mm/s, seen every millisecond.
  for (std::uint32_t i = 0; i < set.marks.size(); ++i) {
    EXPECT_LE(FarthestMissed(set.marks[i], i, rig.seen,
                             [](const SeenPlace& one) { return one.lit; }),
              0.021);
  }
  EXPECT_EQ(rig.machine.grbl.motion().lit_at_rest_us(), 0);
  EXPECT_EQ(rig.machine.grbl.powers(), std::set<double>{400});
  EXPECT_EQ(rig.early_count, 0U);
}

TEST(GrblCourse, ASpindleGoesDownInPassesAndUpBetweenMarks) {
  CourseRig rig(COURSE_TOOL_SPINDLE);
  ASSERT_TRUE(rig.Ready()) << rig.driver->state().message;
  const mark::MarkSet set = Curves(MillPen());
  ASSERT_TRUE(rig.Run(1, set)) << rig.driver->state().fault;
  for (const SeenPlace& one : rig.seen) {
    if (one.at_mm.z() > -1e-4) continue;
    ASSERT_TRUE(one.in_hand);
    ASSERT_LE(DistanceToMark(one.at_mm.head<2>(), set.marks[one.mark]),
              kPathTolerance_mm);
  }
  for (const double depth_mm : {0.2, 0.4, 0.6}) {
    for (std::uint32_t i = 0; i < set.marks.size(); ++i) {
      const auto in_pass = [&](const SeenPlace& one) {
        return std::abs(one.at_mm.z() + depth_mm) < 2e-4;
      };
      EXPECT_LE(FarthestMissed(set.marks[i], i, rig.seen, in_pass), 0.021)
          << "mark " << i << " at " << depth_mm;
    }
  }
  EXPECT_FALSE(rig.machine.grbl.spindle_on());
  EXPECT_NEAR(rig.machine.grbl.WorkPosition_mm().z(), 2, 1e-4);
  EXPECT_EQ(rig.machine.grbl.powers(), std::set<double>{900});
}

TEST(GrblCourse, HolesAreDrilledOneByOne) {
  CourseRig rig(COURSE_TOOL_SPINDLE);
  ASSERT_TRUE(rig.Ready());
  mark::Pen pen = MillPen();
  pen.pass_count = 1;
  mark::MarkSet set{{pen}, {}};
  for (int i = 0; i < 3; ++i) {
    set.marks.push_back({});
    set.marks.back().places = {{{1.5 * i, -2.0 * i}}};
  }
  ASSERT_TRUE(rig.Run(1, set)) << rig.driver->state().fault;
  for (std::uint32_t i = 0; i < 3; ++i) {
    double deepest = 0;
    for (const SeenPlace& one : rig.seen) {
      if (!one.in_hand || one.mark != i || one.at_mm.z() > -1e-4) continue;
      deepest = std::min(deepest, one.at_mm.z());
      ASSERT_LE(DistanceToMark(one.at_mm.head<2>(), set.marks[i]), 2e-4);
    }
    EXPECT_NEAR(deepest, -0.6, 1e-3);
  }
}

TEST(GrblCourse, AControllerWithoutArcsGetsChords) {
  CourseRig rig(COURSE_TOOL_LASER);
  rig.profile.mutable_course_tool()->set_lines_only(true);
  rig.MakeDriver();
  ASSERT_TRUE(rig.Ready());
  const mark::MarkSet set = Curves(LaserPen());
  ASSERT_TRUE(rig.Run(1, set)) << rig.driver->state().fault;
  for (const SeenPlace& one : rig.seen) {
    if (!one.lit) continue;
    ASSERT_LE(DistanceToMark(one.at_mm.head<2>(), set.marks[one.mark]), 0.0013);
  }
}

TEST(GrblCourse, WhatCannotBeMadeIsRefusedAndNothingIsDone) {
  CourseRig rig(COURSE_TOOL_LASER);
  const mark::Pen pen = LaserPen();
  EXPECT_FALSE(rig.driver->Begin(1, std::vector{pen})) << "the line is down";
  EXPECT_FALSE(rig.driver->Append({0, SquareAt(0, 0, 1)}));
  EXPECT_FALSE(rig.driver->RequestPast(1, 0, 1));
  ASSERT_TRUE(rig.Ready());
  mark::Pen deep = pen;
  deep.depth_mm = 1, deep.plunge_mm_s = 1;
  EXPECT_THAT(rig.driver->Begin(1, std::vector{deep}).error().message,
              HasSubstr("is of a spindle"));
  mark::Pen pulsed = pen;
  pulsed.frequency_hz = 20000;
  EXPECT_THAT(rig.driver->Begin(1, std::vector{pulsed}).error().message,
              HasSubstr("20000 Hz"));
  ASSERT_TRUE(rig.driver->Begin(1, std::vector{pen}));
  mark::Mark hole;
  hole.places = {{{1, 1}}};
  EXPECT_THAT(rig.driver->Append({0, hole}).error().message,
              HasSubstr("make it a circle"));
  hole.pen = 4;
  EXPECT_FALSE(rig.driver->Append({0, hole}));
  std::uint32_t number = 0;
  while (rig.driver->Room() > 0)
    ASSERT_TRUE(rig.driver->Append({number++, SquareAt(0, 0, 1)}));
  EXPECT_FALSE(rig.driver->Append({number, SquareAt(0, 0, 1)}));
  ASSERT_TRUE(rig.driver->Stop());
  ASSERT_TRUE(rig.StepUntil([&] { return rig.driver->state().settled; }));
  EXPECT_EQ(rig.CountOf(MarkFate::kNotBegun), number);
  EXPECT_FALSE(rig.driver->Begin(1, std::vector{pen})) << "not above the one before";
  EXPECT_EQ(rig.machine.grbl.motion().steps_made(), 0U);
}

TEST(GrblCourse, NothingMovesBeforeItIsPermitted) {
  CourseRig rig(COURSE_TOOL_LASER);
  ASSERT_TRUE(rig.Ready());
  rig.permits = false;
  rig.StepFor(300ms);
  ASSERT_TRUE(rig.driver->Begin(1, std::vector{LaserPen()}));
  ASSERT_TRUE(rig.driver->Append({0, SquareAt(0, 0, 2)}));
  ASSERT_TRUE(rig.driver->Finish());
  rig.StepFor(500ms);
  EXPECT_TRUE(rig.events.empty());
  EXPECT_FALSE(rig.driver->state().shutter_open);
  EXPECT_FALSE(rig.driver->Reset()) << "a run is under way";
  rig.permits = true;
  rig.Step();
  EXPECT_TRUE(rig.driver->state().shutter_open);
  ASSERT_TRUE(rig.StepUntil([&] { return rig.driver->state().settled; }));
  EXPECT_EQ(rig.LastOf(0), MarkFate::kDone);
}

TEST(GrblCourse, AnotherControllerOrTheWrongModeIsRefused) {
  CourseRig other(COURSE_TOOL_LASER, "G-77");
  other.StepFor(2s);
  EXPECT_FALSE(other.driver->state().link_up);
  EXPECT_THAT(other.driver->state().refusal, HasSubstr("G-77"));
  CourseRig spindle(COURSE_TOOL_SPINDLE);
  spindle.profile = CourseProfile(COURSE_TOOL_LASER);
  spindle.MakeDriver();
  spindle.StepFor(2s);
  EXPECT_THAT(spindle.driver->state().refusal, HasSubstr("set $32=1"));
  CourseRig laser(COURSE_TOOL_LASER);
  laser.profile = CourseProfile(COURSE_TOOL_SPINDLE);
  laser.MakeDriver();
  laser.StepFor(2s);
  EXPECT_THAT(laser.driver->state().refusal, HasSubstr("set $32=0"));
  CourseRig fast(COURSE_TOOL_SPINDLE);
  fast.profile.mutable_course_tool()->set_spindle_rpm(24000);
  fast.MakeDriver();
  ASSERT_TRUE(fast.Ready());
  EXPECT_THAT(fast.driver->Begin(1, std::vector{MillPen()}).error().message,
              HasSubstr("24000 is more than $30=1000"));
}

TEST(GrblCourse, TheSuppliedProfilesHaveWhatTheDriverNeeds) {
  for (const char* name : {"mill", "laser-cutter"}) {
    MachineSpec machine;
    ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(
        intaglio::test::ContentOf(INTAGLIO_SOURCE_DIR "/deploy/machines/" +
                                  std::string(name) + ".textproto"),
        &machine));
    EXPECT_TRUE(CheckGrblCourseProfile(machine).empty());
    machine.mutable_mark_line()->set_device("/dev/null");
    EXPECT_TRUE(MakeMarkDriver(machine)) << name;
  }
}

TEST(GrblCourse, AProfileWithoutItsToolIsRefusedByField) {
  MachineSpec machine = CourseProfile(COURSE_TOOL_SPINDLE);
  EXPECT_TRUE(CheckGrblCourseProfile(machine).empty());
  machine.mutable_course_tool()->clear_spindle_rpm();
  ASSERT_EQ(CheckGrblCourseProfile(machine).size(), 1U);
  EXPECT_THAT(CheckGrblCourseProfile(machine)[0].message,
              HasSubstr("course_tool.spindle_rpm: is missing"));
  machine.clear_course_tool();
  EXPECT_THAT(CheckGrblCourseProfile(machine)[0].message, HasSubstr("course_tool.kind"));
  machine = CourseProfile(COURSE_TOOL_LASER);
  machine.mutable_course_tool()->set_spin_up_s(1);
  EXPECT_EQ(CheckGrblCourseProfile(machine).size(), 1U);
}

}  // namespace
}  // namespace intaglio::drivers
