// Marks of courses: lengths, places and order against elementary geometry.

#include "services/job/course/course_marks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "services/job/convert/model_kind.h"

namespace intaglio {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

/// A plate of 30 x 20 mm with a round hole of 8 mm.
constexpr const char* kPlate =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">)"
    R"(<rect x="5" y="5" width="30" height="20"/><circle cx="20" cy="15" r="4"/></svg>)";
constexpr const char* kSheet =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">)"
    R"(<rect x="5" y="5" width="30" height="20"/></svg>)";
/// Two discs of 2 mm, 4 mm apart.
constexpr const char* kDiscs =
    "%FSLAX46Y46*%%MOMM*%%ADD10C,2.0*%D10*X0Y0D03*X4000000Y0D03*M02*\n";
constexpr const char* kHoles =
    "M48\nMETRIC,TZ\nT1C0.8\nT2C1.2\n%\nT1\nX1.0Y1.0\nX2.0Y1.0\nT2\nX5.0Y1.0\nM30\n";

FileBytes BytesOf(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

struct NamedText {
  std::string name, text;
};

Result<mark::MarkSet> MarksOn(const MachineSpec& machine, Course course,
                              const std::vector<NamedText>& files) {
  JobSpec job;
  std::vector<FileBytes> bytes;
  for (const NamedText& file : files) {
    course.add_files(file.name);
    bytes.push_back(BytesOf(file.text));
  }
  *job.mutable_course() = course;
  Warnings warnings;
  auto made =
      MakeCourseMarks(job, machine, std::move(bytes), ReadLimitsTimes(1), warnings, {});
  if (!made) return made;
  return OrderCourseMarks(job, machine, std::move(*made));
}

Result<mark::MarkSet> MarksOf(const Course& course, const std::vector<NamedText>& files,
                              CourseToolKind tool = COURSE_TOOL_UNKNOWN) {
  MachineSpec machine;
  machine.set_name("mill");
  machine.mutable_course_tool()->set_kind(tool);
  return MarksOn(machine, course, files);
}

double SumOf(const mark::MarkSet& set) {
  double sum_mm = 0;
  for (const mark::Mark& mark : set.marks) sum_mm += mark::LengthOf(mark);
  return sum_mm;
}

Course CourseOf(CourseMake make, double tool_mm) {
  Course course;
  course.set_make(make);
  course.set_tool_diameter_mm(tool_mm);
  return course;
}

TEST(CourseMarks, IsolationIsCirclesAroundPads) {
  Course course = CourseOf(COURSE_MAKE_ISOLATION, 0.2);
  course.set_pass_count(2);
  course.set_depth_mm(0.3);
  course.set_repeat_count(3);
  course.set_speed_mm_s(7);
  course.set_plunge_mm_s(2);
  const auto set = MarksOf(course, {{"board.gbr", kDiscs}}, COURSE_TOOL_SPINDLE);
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->marks.size(), 4U);
  for (const mark::Mark& mark : set->marks) EXPECT_TRUE(mark.closed);
  EXPECT_NEAR(SumOf(*set), 2 * 2 * pi * (1.1 + 1.2), 1e-9);
  ASSERT_EQ(set->pens.size(), 1U);
  EXPECT_EQ(set->pens[0].speed_mm_s, 7);
  EXPECT_EQ(set->pens[0].plunge_mm_s, 2);
  EXPECT_EQ(set->pens[0].depth_mm, 0.3);
  EXPECT_EQ(set->pens[0].pass_count, 3U);
  EXPECT_EQ(set->pens[0].power_ratio, 0);
}

TEST(CourseMarks, ACutFollowsTheCircleExactlyAndInnerContoursComeFirst) {
  Course course = CourseOf(COURSE_MAKE_CUT, 0.2);
  course.set_power_ratio(0.7);
  course.set_lead_mm(1);
  const auto set = MarksOf(course, {{"plate.svg", kPlate}}, COURSE_TOOL_LASER);
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->marks.size(), 2U);
  // Half the kerf inside of the hole: a circle, and two quarters of 1 mm.
  EXPECT_NEAR(mark::LengthOf(set->marks[0]), 2 * pi * 3.9 + pi, 1e-6);
  for (const mark::Place& place : set->marks[0].places)
    EXPECT_LE((place.at_mm - Vec2(20, 15)).norm(), 3.9 + 1e-6);
  EXPECT_NEAR(mark::LengthOf(set->marks[1]), 100 + 2 * pi * 0.1 + pi, 1e-6);
  EXPECT_EQ(set->pens[0].power_ratio, 0.7);
  EXPECT_EQ(set->pens[0].depth_mm, 0);
}

TEST(CourseMarks, PocketsOutlinesAndCurvesAreMarks) {
  const auto pocket = MarksOf(CourseOf(COURSE_MAKE_POCKET, 2), {{"plate.svg", kPlate}});
  ASSERT_TRUE(pocket) << pocket.error().message;
  EXPECT_GT(pocket->marks.size(), 4U);
  for (const mark::Mark& mark : pocket->marks) {
    for (const Vec2& place : mark::PlacesOf(mark, 0.001)) {
      EXPECT_GE(place.x(), 6 - 1e-6);
      EXPECT_LE(place.x(), 34 + 1e-6);
      EXPECT_GE((place - Vec2(20, 15)).norm(), 5 - 0.002);
    }
  }
  Course outline = CourseOf(COURSE_MAKE_OUTLINE, 2);
  outline.set_round_corners(true);
  const auto around = MarksOf(outline, {{"plate.svg", kPlate}});
  ASSERT_TRUE(around) << around.error().message;
  EXPECT_NEAR(SumOf(*around), 100 + 2 * pi + 2 * pi * 3, 1e-6);
  const auto curves = MarksOf(CourseOf(COURSE_MAKE_CURVES, 0.2), {{"plate.svg", kPlate}});
  ASSERT_TRUE(curves) << curves.error().message;
  ASSERT_EQ(curves->marks.size(), 2U);
  EXPECT_NEAR(SumOf(*curves), 100 + 8 * pi, 1e-6);
}

TEST(CourseMarks, TabsStayAboveThePassesThatWouldCutThem) {
  Course course;
  course.set_make(COURSE_MAKE_CUT);
  course.set_tool_diameter_mm(2);
  course.set_depth_mm(3);
  course.set_repeat_count(3);
  course.set_tab_count(2);
  course.set_tab_width_mm(4);
  course.set_tab_height_mm(1);
  const auto made = MarksOf(course, {{"sheet.svg", kSheet}});
  ASSERT_TRUE(made) << made.error().message;
  std::map<double, double> length_by_depth_mm;
  for (const mark::Mark& mark : made->marks) {
    EXPECT_EQ(made->pens[mark.pen].pass_count, 1U);
    length_by_depth_mm[made->pens[mark.pen].depth_mm] += mark::LengthOf(mark);
  }
  // Around a sheet of 30 x 20 mm at 1 mm: whole turns to the tabs' top, then without two
  // tabs, whose ends are as far apart as the tool needs to leave 4 mm.
  ASSERT_EQ(length_by_depth_mm.size(), 3U);
  const double turn_mm = 100 + 2 * pi;
  EXPECT_NEAR(length_by_depth_mm.at(1), turn_mm, 1e-6);
  EXPECT_NEAR(length_by_depth_mm.at(2), turn_mm, 1e-6);
  EXPECT_NEAR(length_by_depth_mm.at(3), turn_mm - 2 * (4 + 2), 1e-6);
}

TEST(CourseMarks, ASpindleMakesTheWorkOfOneTool) {
  const std::vector<NamedText> files = {{"board.gbr", kDiscs}, {"board.drl", kHoles}};
  Course course = CourseOf(COURSE_MAKE_ISOLATION, 0.2);
  const auto both = MarksOf(course, files);
  ASSERT_FALSE(both);
  EXPECT_THAT(both.error().message, HasSubstr("3 tools, contours and holes of 0.8, 1.2"));
  course.set_drill_diameter_mm(0.8);
  course.set_drill_depth_mm(1.7);
  const auto holes = MarksOf(course, files);
  ASSERT_TRUE(holes) << holes.error().message;
  ASSERT_EQ(holes->marks.size(), 2U);
  EXPECT_EQ(holes->pens[holes->marks[0].pen].depth_mm, 1.7);
  for (const mark::Mark& hole : holes->marks) {
    ASSERT_EQ(hole.places.size(), 1U);
    EXPECT_NEAR(hole.places[0].at_mm.y(), 1, 1e-9);
  }
  course.set_drill_diameter_mm(0);
  const auto contours = MarksOf(course, files);
  ASSERT_TRUE(contours) << contours.error().message;
  EXPECT_NEAR(SumOf(*contours), 2 * 2 * pi * 1.1, 1e-9);
  course.set_drill_diameter_mm(1);
  const auto none = MarksOf(course, files);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message,
              HasSubstr("no hole has 1 mm; the files have holes of"));
}

TEST(CourseMarks, ALaserCutsHolesAsCirclesInsideTheKerf) {
  Course course = CourseOf(COURSE_MAKE_OUTLINE, 0.1);
  course.set_power_ratio(0.5);
  const auto set = MarksOf(course, {{"board.drl", kHoles}}, COURSE_TOOL_LASER);
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->marks.size(), 3U);
  EXPECT_NEAR(SumOf(*set), pi * (0.7 + 0.7 + 1.1), 1e-9);
  course.set_tool_diameter_mm(1);
  const auto wide = MarksOf(course, {{"board.drl", kHoles}}, COURSE_TOOL_LASER);
  ASSERT_FALSE(wide);
  EXPECT_THAT(wide.error().message, HasSubstr("a kerf of 1 mm cuts no holes of 0.8 mm"));
}

TEST(CourseMarks, TheToolHasToBeThatOfTheMachine) {
  Course course = CourseOf(COURSE_MAKE_OUTLINE, 0.1);
  EXPECT_THAT(MarksOf(course, {{"board.gbr", kDiscs}}, COURSE_TOOL_LASER).error().message,
              HasSubstr("course.power_ratio: is missing; the tool of mill is a laser"));
  course.set_safe_height_mm(8);
  EXPECT_THAT(
      MarksOf(course, {{"board.gbr", kDiscs}}, COURSE_TOOL_SPINDLE).error().message,
      HasSubstr("course.safe_height_mm: 8 is more than the 5 mm"));
  course.set_power_ratio(0.5);
  EXPECT_THAT(
      MarksOf(course, {{"board.gbr", kDiscs}}, COURSE_TOOL_SPINDLE).error().message,
      HasSubstr("course.power_ratio: 0.5 is of a laser"));
}

TEST(CourseMarks, ABeamThatIsOnOrOffHasTheWholePowerAndTheSpeedOfTheAxes) {
  MachineSpec machine;
  machine.set_name("cutter");
  machine.mutable_mark_line()->set_protocol("linuxcnc-course");
  machine.mutable_course_tool()->set_kind(COURSE_TOOL_LASER);
  machine.mutable_x()->set_max_speed_mm_s(50);
  machine.mutable_y()->set_max_speed_mm_s(40);
  Course course = CourseOf(COURSE_MAKE_OUTLINE, 0.1);
  const auto made = [&](double power_ratio, double speed_mm_s) {
    course.set_power_ratio(power_ratio);
    course.set_speed_mm_s(speed_mm_s);
    const auto set = MarksOn(machine, course, {{"plate.svg", kPlate}});
    return set ? "" : set.error().message;
  };
  EXPECT_THAT(made(0.5, 30),
              HasSubstr("course.power_ratio: 0.5: the output of cutter is on or off"));
  EXPECT_EQ(made(1, 30), "");
  EXPECT_THAT(made(1, 41), HasSubstr("course.speed_mm_s: 41 is more than the 40 mm/s"));
}

TEST(CourseMarks, FilesComeInTheOrderOfTheJob) {
  JobSpec job;
  job.mutable_course()->add_files("a.gbr");
  job.mutable_course()->add_files("b.drl");
  EXPECT_THAT(CourseMarkFilesOf(job), testing::ElementsAre("a.gbr", "b.drl"));
}

TEST(CourseMarks, WhatADrawingHoldsAndIsNotMadeIsReported) {
  JobSpec job;
  job.mutable_course()->add_files("plate.svg");
  job.mutable_course()->set_make(COURSE_MAKE_CUT);
  job.mutable_course()->set_tool_diameter_mm(1);
  const std::string svg =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" )"
      R"(viewBox="0 0 40 20"><rect x="5" y="5" width="30" height="10"/>)"
      R"(<text x="1" y="1">price</text></svg>)";
  Warnings warnings;
  const auto set =
      MakeCourseMarks(job, {}, {BytesOf(svg)}, ReadLimitsTimes(1), warnings, {});
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, WarningCode::kLeftOut);
  EXPECT_THAT(warnings[0].text, HasSubstr("plate.svg"));
}

TEST(CourseMarks, ACancelledMakingIsAnError) {
  JobSpec job;
  job.mutable_course()->add_files("board.gbr");
  Warnings warnings;
  const auto set =
      MakeCourseMarks(job, {}, {BytesOf(kDiscs)}, ReadLimitsTimes(1), warnings,
                      [](std::uint64_t, std::uint64_t) { return false; });
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace intaglio
