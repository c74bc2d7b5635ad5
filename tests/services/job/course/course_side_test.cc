// What draws the back of a board is machined with the board turned over, and the outline
// of a board of KiCad is what is cut.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <variant>

#include "engrave/contour/mirror.h"
#include "services/job/course/course_files.h"
#include "tests/engrave/contour/files/kicad_text.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// 20 x 10 mm from x = 10 on, its middle at 20; a pad with a hole at x = 13.
std::string Board() {
  contour::test::KicadText text;
  text.Outline(10, 0, 20, 10);
  text.Footprint("R1", 10, 0);
  text.Pad("1", "circle", 3, 3, 2, 2, "A", 0.8);
  text.EndFootprint();
  return text.Text();
}

/// A pad at x = 5.
std::string Layer(const std::string& head) {
  return "%FSLAX46Y46*%%MOMM*%" + head + "%ADD10C,2.0*%D10*X5000000Y1000000D03*M02*\n";
}

struct SideRead {
  Result<CourseFiles> files;
  Warnings warnings;
};

SideRead Read(const std::string& file, const std::string& text, const std::string& layer,
              const CourseFileOptions& options = {},
              CourseMake make = COURSE_MAKE_ISOLATION) {
  Course course;
  course.add_files(file);
  course.set_layer(layer);
  course.set_make(make);
  Warnings warnings;
  auto files = CourseFilesOf(course, {text}, {}, warnings, options);
  return {std::move(files), std::move(warnings)};
}

/// The middle of the first element, a round pad.
double PadX(const SideRead& read) {
  if (!read.files || read.files->elements.empty()) return -1e9;
  const auto* pad = std::get_if<contour::Circle>(&read.files->elements.front().shape);
  return pad != nullptr ? pad->center_mm.x() : -1e9;
}

TEST(CourseSide, TheFrontStaysAsItIsDrawn) {
  const auto read = Read("a.kicad_pcb", Board(), "F.Cu");
  EXPECT_NEAR(PadX(read), 13, 1e-9);
  EXPECT_THAT(read.warnings, IsEmpty());
}

TEST(CourseSide, TheBackIsTurnedOverAboutTheMiddleOfTheBoardWithANote) {
  const auto read = Read("a.kicad_pcb", Board(), "B.Cu");
  EXPECT_NEAR(PadX(read), 27, 1e-9);
  ASSERT_THAT(read.files->holes, SizeIs(1));
  EXPECT_NEAR(read.files->holes[0].center_mm.x(), 27, 1e-9);
  EXPECT_NEAR(std::get<contour::Circle>(read.files->boards[0].elements[0].element.shape)
                  .center_mm.x(),
              27, 1e-9);
  ASSERT_THAT(read.warnings, SizeIs(1));
  EXPECT_EQ(read.warnings[0].weight, WarningWeight::kNote);
  EXPECT_THAT(read.warnings[0].text,
              AllOf(HasSubstr("layer B.Cu of a.kicad_pcb"), HasSubstr("x = 20 mm")));
}

// Both sides have the same holes: what lies on the line stays where it is when the board
// is turned over about it.
TEST(CourseSide, AlignmentHolesLieOnTheLineOfBothSides) {
  CourseFileOptions options;
  options.alignment_y_mm = {-5, 15};
  options.alignment_diameter_mm = 2.5;
  for (const char* layer : {"F.Cu", "B.Cu"}) {
    const auto read = Read("a.kicad_pcb", Board(), layer, options);
    ASSERT_TRUE(read.files) << read.files.error().message;
    ASSERT_THAT(read.files->holes, SizeIs(3));
    for (int k = 0; k < 2; ++k) {
      const contour::Hole& hole = read.files->holes[static_cast<std::size_t>(1 + k)];
      EXPECT_EQ(hole.center_mm, Vec2(20, k == 0 ? -5 : 15)) << layer;
      EXPECT_EQ(hole.diameter_mm, 2.5);
    }
    EXPECT_THAT(read.warnings.back().text,
                HasSubstr("alignment holes of 2.5 mm at (20, -5) and (20, 15) mm"));
  }
}

TEST(CourseSide, ABackThatIsNotTurnedOverIsAWarning) {
  const auto read = Read("a.kicad_pcb", Board(), "B.Cu", {{}, false, {}});
  EXPECT_NEAR(PadX(read), 13, 1e-9);
  ASSERT_THAT(read.warnings, SizeIs(1));
  EXPECT_EQ(read.warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(read.warnings[0].text, HasSubstr("is not mirrored"));
}

TEST(CourseSide, AGerberFileThatDeclaresTheBackIsTurnedOver) {
  for (const char* head : {"%TF.FileFunction,Copper,L2,Bot*%",
                           "G04 #@! TF.FileFunction,Copper,L2,Bot,Signal*"}) {
    const auto read = Read("a.gbr", Layer(head), "");
    EXPECT_NEAR(PadX(read), -5, 1e-9) << head;
    EXPECT_THAT(read.warnings, SizeIs(1)) << head;
    EXPECT_NEAR(PadX(Read("a.gbr", Layer(head), "", {{}, {}, 10})), 15, 1e-9);
  }
  for (const char* head :
       {"", "%TF.FileFunction,Copper,L1,Top*%", "%TF.FileFunction,Soldermask,Bot*%"}) {
    const auto read = Read("a.gbr", Layer(head), "");
    EXPECT_NEAR(PadX(read), 5, 1e-9) << head;
    EXPECT_THAT(read.warnings, IsEmpty()) << head;
  }
}

TEST(CourseSide, AskedForItIsTurnedOverWhateverTheFilesDeclare) {
  const auto read = Read("a.gbr", Layer(""), "", {{}, true, 7});
  EXPECT_NEAR(PadX(read), 9, 1e-9);
  ASSERT_THAT(read.warnings, SizeIs(1));
  EXPECT_THAT(read.warnings[0].text, HasSubstr("x = 7 mm"));
}

TEST(CourseSide, CutsAreAlongTheOutlineOfABoard) {
  for (const char* layer : {"", "Edge.Cuts"}) {
    const auto read = Read("a.kicad_pcb", Board(), layer, {}, COURSE_MAKE_CUT);
    ASSERT_TRUE(read.files) << read.files.error().message;
    ASSERT_THAT(read.files->elements, SizeIs(1));
    const auto* outline = std::get_if<contour::Outline>(&read.files->elements[0].shape);
    ASSERT_NE(outline, nullptr);
    ASSERT_THAT(outline->loops, SizeIs(1));
    EXPECT_NEAR(std::abs(contour::AreaOf(outline->loops[0])), 200, 1e-6);
    EXPECT_THAT(read.files->boards, IsEmpty());
  }
  const auto curves = Read("a.kicad_pcb", Board(), "Edge.Cuts", {}, COURSE_MAKE_CURVES);
  ASSERT_TRUE(curves.files) << curves.files.error().message;
  EXPECT_THAT(curves.files->curves, SizeIs(1));
}

TEST(CourseSide, ABoardWithoutAnOutlineIsNotCut) {
  contour::test::KicadText text;
  text.Footprint("R1", 10, 0);
  text.Pad("1", "circle", 3, 3, 2, 2, "A", 0.8);
  text.EndFootprint();
  const auto read = Read("a.kicad_pcb", text.Text(), "", {}, COURSE_MAKE_CUT);
  ASSERT_FALSE(read.files);
  EXPECT_THAT(read.files.error().message, HasSubstr("has no outline on Edge.Cuts"));
}

// Points of an arc by their angles, mirrored one by one.
TEST(Mirror, ArcsStayExact) {
  const contour::Edge arc = contour::MakeArc({3, 4}, 2, 0.3, 1.9);
  const contour::Edge mirrored = contour::Mirrored(arc, 1.5);
  for (const double part : {0.0, 0.25, 0.5, 1.0}) {
    const Vec2 place = contour::PointAt(arc, part * arc.length_mm);
    const Vec2 there = contour::PointAt(mirrored, part * mirrored.length_mm);
    EXPECT_NEAR(there.x(), 3 - place.x(), 1e-12);
    EXPECT_NEAR(there.y(), place.y(), 1e-12);
  }
  EXPECT_NEAR((mirrored.end_mm - contour::PointAt(mirrored, mirrored.length_mm)).norm(),
              0, 1e-12);
}

}  // namespace
}  // namespace intaglio
