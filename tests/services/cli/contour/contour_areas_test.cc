// `intaglio contour` of boards whose nets are known, of pockets and of cuts.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "services/cli/contour/contour_command.h"
#include "services/cli/contour/contour_files.h"
#include "services/client/exit_codes.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/course/course_work.h"
#include "tests/engrave/contour/files/kicad_text.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;

class ContourAreas : public TypedCommand {
 protected:
  std::string Write(const std::string& name, const std::string& text) {
    const std::string file = folder_ / name;
    std::ofstream(file) << text;
    return file;
  }
  int Type(std::vector<std::string> words) {
    words.insert(words.begin(), "contour");
    return TypeTo(AddContourCommand, words);
  }
  /// Two pads of each of two nets, the one net joined in front, the other behind.
  static std::string Board(bool joined) {
    contour::test::KicadText text;
    text.Outline(0, 0, 20, 10);
    text.Footprint("R1", 0, 0);
    text.Pad("1", "circle", 3, 3, 2, 2, "A", 0.8);
    text.Pad("2", "circle", 17, 3, 2, 2, "A", 0.8);
    text.Pad("3", "circle", 3, 7, 2, 2, "B", 0.8);
    text.Pad("4", "circle", 17, 7, 2, 2, "B", 0.8);
    text.EndFootprint();
    text.Segment(3, 3, 17, 3, 0.5, "A");
    if (joined) text.Segment(3, 7, 17, 7, 0.5, "B", "B.Cu");
    return text.Text();
  }
};

TEST_F(ContourAreas, TheCopperLeftOfABoardHasTheNetsOfItsFile) {
  const std::string board = Write("board.kicad_pcb", Board(true));
  ASSERT_EQ(Type({board, "--tool", "0.3"}), client::kExitGood) << errors_;
  EXPECT_THAT(output_, HasSubstr("copper left   2 nets as the file has them"));
  EXPECT_THAT(output_, HasSubstr("isolation     3 nets")) << "B is two pads in front";
  EXPECT_THAT(output_, HasSubstr("4 holes with 1 tool"));
  ASSERT_EQ(Type({board, "--tool", "0.3", "--layer", "B.Cu"}), client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("copper left   2 nets as the file has them"));
}

TEST_F(ContourAreas, ANetInPartsAndALayerThatIsNoneAreRefusedByName) {
  const std::string open = Write("open.kicad_pcb", Board(false));
  EXPECT_EQ(Type({open, "--tool", "0.3"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("has not the nets of the file"));
  EXPECT_THAT(errors_, HasSubstr("B"));
  const std::string board = Write("board.kicad_pcb", Board(true));
  EXPECT_EQ(Type({board, "--layer", "In1.Cu"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("it has F.Cu, B.Cu"));
}

/// A plate of 30 x 20 mm with a hole of 8 mm square.
constexpr const char* kPlate =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">)"
    R"(<rect x="5" y="5" width="30" height="20"/><rect x="16" y="11" width="8" height="8"/></svg>)";

TEST_F(ContourAreas, APocketOfManyEdgesKeepsAStripAlongItsWalls) {
  std::string points;
  for (int i = 0; i < 2000; ++i) {
    const double turn = 2 * std::numbers::pi * i / 2000;
    points +=
        fmt::format("{:.5f},{:.5f} ", 20 + 15 * std::cos(turn), 20 + 15 * std::sin(turn));
  }
  Course course;
  course.add_files(Write(
      "zone.svg",
      fmt::format(R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" )"
                  R"(viewBox="0 0 40 40"><polygon points="{}"/></svg>)",
                  points)));
  course.set_tool_diameter_mm(2);
  course.set_make(COURSE_MAKE_POCKET);
  Warnings warnings;
  const auto files = ReadCourseFiles(WithDefaults(course), 1, warnings);
  ASSERT_TRUE(files) << files.error().message;
  const auto pocket = MakeContourWork(WithDefaults(course), *files, Vec2(0, 0));
  ASSERT_TRUE(pocket) << pocket.error().message;
  EXPECT_NEAR(pocket->left_at_wall_mm, 0.004, 1e-9);
  EXPECT_LE(pocket->left_mm2, 2 * std::numbers::pi * 15 * pocket->left_at_wall_mm);
}

TEST_F(ContourAreas, APocketIsClearedAndACutGoesAroundIt) {
  Course course;
  course.add_files(Write("plate.svg", kPlate));
  course.set_tool_diameter_mm(2);
  course.set_make(COURSE_MAKE_POCKET);
  Warnings warnings;
  const auto files = ReadCourseFiles(WithDefaults(course), 1, warnings);
  ASSERT_TRUE(files) << files.error().message;
  const auto pocket = MakeContourWork(WithDefaults(course), *files, Vec2(0, 0));
  ASSERT_TRUE(pocket) << pocket.error().message;
  // Each outer corner keeps a square of the radius less its quarter of a disc; those of
  // the hole point away from the tool.
  EXPECT_NEAR(pocket->left_mm2, 4 * (1 - std::numbers::pi / 4), 1e-3);
  EXPECT_EQ(pocket->left_at_wall_mm, 0) << "its outlines have few edges";
  for (const post::ToolPath& path : pocket->paths) {
    EXPECT_GE(path.begin_mm.x(), 6 - 1e-6);
    EXPECT_LE(path.begin_mm.x(), 34 + 1e-6);
  }
  course.set_make(COURSE_MAKE_CUT);
  course.set_lead_mm(1);
  const auto cut = MakeContourWork(WithDefaults(course), *files, Vec2(0, 0));
  ASSERT_TRUE(cut) << cut.error().message;
  ASSERT_EQ(cut->paths.size(), 2U) << "the hole, then the plate";
  // Two quarter arcs of 1 mm each; inside a square with corners, outside with arcs.
  const double leads_mm = 2 * 2 * std::numbers::pi / 2;
  const double hole_mm = 4 * 6, plate_mm = 2 * (30 + 20) + 2 * std::numbers::pi;
  EXPECT_NEAR(cut->work_mm, leads_mm + hole_mm + plate_mm, 1e-3);
  EXPECT_LT(contour::LengthOf(post::EdgesOf(cut->paths[0])),
            contour::LengthOf(post::EdgesOf(cut->paths[1])));
}

// Tabs every 30 mm of 106.28 mm are four; of each its width and the tool's are at its
// top once, and above the part in the pass that follows.
TEST_F(ContourAreas, TabsStayInTheProgramOfACut) {
  const std::string plate = Write("plate.svg", kPlate);
  const std::string out = folder_ / "plate.ngc", picture = folder_ / "plate_cut.svg";
  ASSERT_EQ(Type({plate, "--make", "cut", "--tool", "2", "--depth", "3", "--repeat", "3",
                  "--tab-distance", "30", "--tab-height", "1", "--template",
                  INTAGLIO_SOURCE_DIR "/deploy/post/mill/linuxcnc.post", "--out", out,
                  "--picture", picture}),
            client::kExitGood)
      << errors_;
  const std::string program = test::ContentOf(out);
  const auto count = [](const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
      ++found;
    return found;
  };
  // The hole and the plate whole at -1 and -2; at -3 the hole whole, the plate in five.
  EXPECT_EQ(count(program, "G1 Z-1.0000"), 2U);
  EXPECT_EQ(count(program, "G1 Z-2.0000"), 2U);
  EXPECT_EQ(count(program, "G1 Z-3.0000"), 1U + 5U);
  EXPECT_EQ(count(test::ContentOf(picture), "class=\"tab\""), 4U);
}

// The hole of a plate has no tabs around an outline; a curve has its own, also a round
// one without a straight piece. At work is what is left of the way in the deeper of two
// passes.
TEST_F(ContourAreas, OutlinesAndCurvesHaveTabsToo) {
  Course course;
  course.add_files(Write("plate.svg", kPlate));
  course.set_tool_diameter_mm(2);
  course.set_tab_count(4);
  const auto tab_length_mm = [&](CourseMake make) {
    course.set_make(make);
    Warnings warnings;
    const auto files = ReadCourseFiles(WithDefaults(course), 1, warnings);
    const auto work = MakeContourWork(WithDefaults(course), *files, Vec2(0, 0));
    EXPECT_TRUE(work) << work.error().message;
    double sum_mm = 0;
    for (const post::ToolPath& path : work->paths) {
      Vec2 at_mm = path.begin_mm;
      for (const post::WorkMove& move : path.moves) {
        if (move.tab) sum_mm += (move.end_mm - at_mm).norm();
        at_mm = move.end_mm;
      }
    }
    return sum_mm;
  };
  EXPECT_NEAR(tab_length_mm(COURSE_MAKE_OUTLINE), 4 * (3 + 2), 1e-6);
  course.set_files(
      0, Write("disc.svg", R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" )"
                           R"(height="30mm" viewBox="0 0 40 30">)"
                           R"(<circle cx="20" cy="15" r="9"/></svg>)"));
  EXPECT_NEAR(tab_length_mm(COURSE_MAKE_CURVES), 4 * (3 + 2), 1e-6)
      << "the ends of a tab are as far apart on an arc as on a line";
}

TEST_F(ContourAreas, TabsThatCannotBeAreRefusedByName) {
  const std::string plate = Write("plate.svg", kPlate);
  EXPECT_EQ(Type({plate, "--make", "pocket", "--tabs", "4"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("course.tab_count"));
  EXPECT_EQ(Type({plate, "--make", "cut", "--tab-width", "4"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("tab_distance_mm"));
  EXPECT_EQ(Type({plate, "--make", "cut", "--tabs", "2", "--tab-height", "1"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("is more than depth_mm, 0.2"));
  EXPECT_EQ(Type({plate, "--make", "cut", "--tabs", "2", "--tab-height", "1", "--power",
                  "0.5"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("a laser leaves tabs whole"));
  EXPECT_EQ(Type({plate, "--make", "cut", "--tabs", "50"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("of 50 tabs"));
}

TEST_F(ContourAreas, WhatIsOfCutsAloneIsRefusedOfOthers) {
  const std::string plate = Write("plate.svg", kPlate);
  EXPECT_EQ(Type({plate, "--make", "pocket", "--inside"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("course.inside are of cuts"));
  EXPECT_EQ(Type({plate, "--make", "cut", "--overlap", "0.6"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("course.overlap_ratio"));
  EXPECT_EQ(Type({plate, "--make", "cut", "--inside", "--tool", "9"}),
            client::kExitWrongInput)
      << output_;
}

}  // namespace
}  // namespace intaglio::cli
