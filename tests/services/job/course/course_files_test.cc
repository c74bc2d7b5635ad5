// What the files of a course hold that is not made, or does not fit, reaches the person
// as warnings with figures.

#include "services/job/course/course_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/course/course_marks.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Pads of 2 mm at (0, 0), (20, 0) and (0, 20).
constexpr const char* kPads =
    "%FSLAX46Y46*%%MOMM*%%ADD10C,2.0*%D10*X0Y0D03*X20000000Y0D03*X0Y20000000D03*M02*\n";

std::string DrillFile(const std::string& places) {
  return "M48\nMETRIC,TZ\nT1C0.8\n%\nT1\n" + places + "M30\n";
}

struct CourseRead {
  Result<CourseFiles> files;
  Warnings warnings;
};

CourseRead ReadTwo(const std::string& layer, const std::string& drill,
                   const std::string& units = {}) {
  Course course;
  course.add_files("a.gbr");
  course.add_files("a.drl");
  Warnings warnings;
  auto files = CourseFilesOf(course, {layer, drill}, {}, warnings, {units, {}, {}});
  return {std::move(files), std::move(warnings)};
}

TEST(CourseFiles, HolesInCopperAreNoWarning) {
  const auto read = ReadTwo(kPads, DrillFile("X0.0Y0.0\nX20.0Y0.0\nX0.0Y20.5\n"));
  ASSERT_TRUE(read.files) << read.files.error().message;
  EXPECT_THAT(read.files->holes, SizeIs(3));
  EXPECT_THAT(read.warnings, IsEmpty());
}

TEST(CourseFiles, PointsOfADrawingAreAWarning) {
  Course course;
  course.add_files("a.plt");
  course.set_make(COURSE_MAKE_CURVES);
  Warnings warnings;
  const auto files = CourseFilesOf(
      course, {"IN;PU400,0;PD;PU;PU0,0;PD400,0;PU;PU800,400;PD;PU;"}, {}, warnings, {});
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_THAT(files->curves, SizeIs(1));
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_EQ(warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(warnings[0].text,
              AllOf(HasSubstr("a.plt: 2 x point"), HasSubstr("(10, 0)")));
}

TEST(CourseFiles, ToolPathsAreCurvesAndTheirHolesAWarning) {
  Course course;
  course.add_files("a.NCI");
  course.set_make(COURSE_MAKE_CURVES);
  Warnings warnings;
  const auto files = CourseFilesOf(course,
                                   {"0\n0 0 0 5 -2 0\n1\n0 0 0 -1 9 0\n1\n0 8 0 -1 9 0\n"
                                    "3\n0 0 8 4 8 2 -1 9 0 0\n81\n0 1 1 0\n1003\n\n"},
                                   {}, warnings, {});
  ASSERT_TRUE(files) << files.error().message;
  ASSERT_THAT(files->curves, SizeIs(1));
  EXPECT_THAT(files->curves[0].edges, SizeIs(2)) << "a line and an arc";
  EXPECT_THAT(warnings,
              Contains(Field(&Warning::text,
                             AllOf(HasSubstr("a.NCI: 1 x hole of a drilling cycle"),
                                   HasSubstr("line 9"), HasSubstr("missing")))));
}

// Digits that are wrong by a power of ten put all but the first there.
TEST(CourseFiles, HolesBesideAllCopperAreAWarningWithFigures) {
  const auto read = ReadTwo(kPads, DrillFile("X0.0Y0.0\nX2.0Y0.0\nX0.0Y2.0\n"));
  ASSERT_TRUE(read.files) << read.files.error().message;
  ASSERT_THAT(read.warnings, SizeIs(1));
  EXPECT_EQ(read.warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(read.warnings[0].text,
              AllOf(HasSubstr("a.drl: 2 of 3 holes lie beside all copper"),
                    HasSubstr("the first 0.8 mm at (2, 0)"),
                    HasSubstr("copper from (-1, -1) to (21, 21) mm")));
}

TEST(CourseFiles, HolesOverEachOtherAreAWarningWithFigures) {
  const auto read =
      ReadTwo(kPads, DrillFile("X0.0Y0.0\nX20.0Y0.0\nX0.3Y0.0\nX0.0Y0.0\n"));
  ASSERT_TRUE(read.files) << read.files.error().message;
  ASSERT_THAT(read.warnings, SizeIs(1));
  EXPECT_THAT(read.warnings[0].text,
              AllOf(HasSubstr("a.drl: 3 pairs of holes lie over each other"),
                    HasSubstr("by up to 0.8 mm")));
}

TEST(CourseFiles, UnitsThatADrillFileLacksAreGiven) {
  const std::string open = "M48\nT1C0.04\n%\nT1\nX15000Y0\nM30\n";
  EXPECT_FALSE(ReadTwo(kPads, open).files);
  const auto read = ReadTwo(kPads, open, "INCH,TZ");
  ASSERT_TRUE(read.files) << read.files.error().message;
  EXPECT_NEAR(read.files->holes[0].center_mm.x(), 38.1, 1e-9);
  const auto wrong = ReadTwo(kPads, open, "FEET");
  ASSERT_FALSE(wrong.files);
  EXPECT_THAT(wrong.files.error().message, HasSubstr("--drill-units"));
}

TEST(CourseFiles, UnitsThatADrillFileHasWrongAreReplacedWithAWarning) {
  Course course;
  course.add_files("a.drl");
  Warnings warnings;
  CourseFileOptions options;
  options.drill_units = "METRIC";
  options.replace_drill_units = true;
  const auto files = CourseFilesOf(course, {"M48\nINCH\nT1C0.8\n%\nT1\nX10.0Y0.0\nM30\n"},
                                   {}, warnings, options);
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_NEAR(files->holes[0].center_mm.x(), 10, 1e-9);
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_EQ(warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(warnings[0].text,
              HasSubstr("a.drl: 1 x INCH of the file, METRIC as given (line 2)"));
}

// A slot of 0.8 mm, 3 mm long: 9 parts of at most 0.43 of its width, so 12.
TEST(CourseFiles, SlotsAloneAreDrilledOrMilled) {
  Course course;
  course.add_files("slots.drl");
  course.set_tool_diameter_mm(0.8);
  Warnings warnings;
  const std::string text =
      intaglio::test::ContentOf(INTAGLIO_SOURCE_DIR "/tests/data/boards/slots_only.drl");
  const auto drilled = CourseFilesOf(course, {text}, {}, warnings);
  ASSERT_TRUE(drilled) << drilled.error().message;
  EXPECT_THAT(drilled->holes, SizeIs(13));
  EXPECT_THAT(warnings, SizeIs(1)) << "rows of holes are not holes over each other";
  course.set_make(COURSE_MAKE_CURVES);
  const auto milled = CourseFilesOf(course, {text}, {}, warnings);
  ASSERT_TRUE(milled) << milled.error().message;
  EXPECT_TRUE(milled->holes.empty());
  ASSERT_THAT(milled->curves, SizeIs(1));
  EXPECT_NEAR(contour::LengthOf(milled->curves[0].edges), 3, 1e-9);
}

// A job on a machine has them, too.
TEST(CourseFiles, WarningsReachTheMarksOfAJob) {
  JobSpec job;
  job.mutable_course()->add_files("a.drl");
  const std::string text = DrillFile("X0.0Y0.0\nX0.3Y0.0\n");
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  Warnings warnings;
  const auto marks = MakeCourseMarks(job, MachineSpec{}, {{begin, begin + text.size()}},
                                     {}, warnings, {});
  ASSERT_TRUE(marks) << marks.error().message;
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_EQ(warnings[0].weight, WarningWeight::kWarning);
}

}  // namespace
}  // namespace intaglio
