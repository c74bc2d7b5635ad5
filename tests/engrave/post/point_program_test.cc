#include "engrave/post/point_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/test_folder.h"

namespace intaglio::post {
namespace {

namespace fs = std::filesystem;

Template Parsed(std::string_view text) {
  auto parsed = ParsePointTemplate(text, "a.post");
  EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
  return parsed ? std::move(*parsed) : Template{};
}

std::string Written(const Template& program, const PointProgram& points) {
  const fs::path file = test::FreshFolder() / "a.nc";
  const Status written = WritePointProgram(file, program, points);
  EXPECT_TRUE(written) << (written ? "" : written.error().message);
  return written ? test::ContentOf(file) : "";
}

TEST(PointProgram, HasEveryPointOnceInItsOrder) {
  const Template program = Parsed(
      "#fragment begin\n(@NAME@ @COUNT@)\n#fragment point\nN@N@ P@I@ X@X@ Y@Y@ Z@Z@\n"
      "#fragment end\nN@N@ END @COUNT@\n");
  EXPECT_EQ(
      Written(program, {"a\nb", {{1, 2, 3}, {-1, 0, 0.5}}}),
      "(a b 2)\nN1 P1 X1.000 Y2.000 Z3.000\nN2 P2 X-1.000 Y0.000 Z0.500\nN3 END 2\n");
}

TEST(PointProgram, MarksLieThroughTheirPointsAlongTheWay) {
  const Template program = Parsed(
      "#mark 0.1\n#number SX SY SZ EX EY EZ decimals=6\n"
      "#fragment point\n@SX@ @SY@ @SZ@ @EX@ @EY@ @EZ@\n");
  const PointList axes = {{0, 0, 0}, {3, 4, 0}, {3, 4, 0}};
  // 3-4-5: half of the mark is 0.05 mm along (0.6, 0.8, 0).
  EXPECT_EQ(Written(program, {"", axes}),
            "-0.050000 0.000000 0.000000 0.050000 0.000000 0.000000\n"
            "2.970000 3.960000 0.000000 3.030000 4.040000 0.000000\n"
            "2.950000 4.000000 0.000000 3.050000 4.000000 0.000000\n");
}

TEST(PointProgram, EveryPointHasItsOwnPower) {
  const Template program = Parsed(
      "#number POWER scale=1000 decimals=0\n#fragment begin\nS@POWER@\n"
      "#fragment point\nX@X@ Y@Y@ Z@Z@ S@POWER@\n");
  PointProgram points{"", {{1, 2, 3}, {4, 5, 6}}};
  points.power_ratio = 0.8;
  points.power_ratios = {0.25, 0.8};
  EXPECT_EQ(Written(program, points),
            "S800\nX1.000 Y2.000 Z3.000 S250\nX4.000 Y5.000 Z6.000 S800\n");
  const auto refused = WritePointProgram(
      test::FreshFolder() / "a.nc", Parsed("#fragment point\n@X@ @Y@ @Z@\n"), points);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "a.post: fragment 'point' does not use @POWER@, and the points have several "
            "pulse energies; add it, or write a program for each energy");
}

TEST(PointProgram, AnEmptyCloudIsBeginAndEnd) {
  EXPECT_EQ(Written(Parsed("#fragment begin\nG21\n#fragment point\n@X@@Y@@Z@\n"), {}),
            "G21\n");
}

TEST(PointProgram, RefusesTemplatesThatLoseACoordinate) {
  const auto error = [](std::string_view text) {
    const auto parsed = ParsePointTemplate(text, "a.post");
    return parsed ? "no error" : parsed.error().message;
  };
  EXPECT_EQ(error("#fragment point\n@X@ @Y@\n"),
            "a.post: fragment 'point' uses neither @Z@ nor @SZ@ and @EZ@, so this "
            "coordinate would be lost");
  EXPECT_EQ(error("#fragment point\n@SX@ @EX@ @Y@ @Z@\n"),
            "a.post: @SX@ needs the length of the mark; add #mark");
  EXPECT_EQ(error("#flat 0.1\n#fragment point\n@X@ @Y@\n"), "no error");
}

TEST(PointProgram, RefusesDepthsOnAMachineWithoutZ) {
  const Template flat = Parsed("#flat 0.1\n#fragment point\n@X@ @Y@\n");
  const fs::path file = test::FreshFolder() / "a.plt";
  const Status status = WritePointProgram(file, flat, {"", {{0, 0, 1}, {0, 0, 1.2}}});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(status.error().message,
            "a.post: this controller has no z, and the points lie between z 1.000 and "
            "1.200 mm; choose a machine with three axes, or engrave one layer");
  EXPECT_FALSE(fs::exists(file));
  EXPECT_TRUE(WritePointProgram(file, flat, {"", {{0, 0, 1}, {0, 0, 1.05}}}));
}

TEST(PointProgram, RefusesMarksOnAxesThatTurn) {
  const Template marks =
      Parsed("#mark 0.1\n#turning 2\n#fragment point\n@SX@@EX@@SY@@EY@@SZ@@EZ@\n");
  const fs::path file = test::FreshFolder() / "a.nc";
  const Status status = WritePointProgram(file, marks, {"", {}, 2});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message,
            "a.post: marks of a length need three axes that do not turn");
}

TEST(PointProgram, RefusesATemplateForOtherAxes) {
  const Template linear = Parsed("#fragment point\n@X@@Y@@Z@\n");
  const fs::path file = test::FreshFolder() / "a.nc";
  const Status status = WritePointProgram(file, linear, {"", {}, 2});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(status.error().message,
            "a.post: this template is for 0 axes that turn, the machine has 2; choose or "
            "write a template with '#turning 2'");
}

TEST(PointProgram, SuppliedTemplatesAreGood) {
  int templates = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(INTAGLIO_SOURCE_DIR) / "deploy/post")) {
    if (entry.is_directory()) continue;
    const std::string file = entry.path().string();
    const auto parsed = ParsePointTemplate(test::ContentOf(entry.path()), file);
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_FALSE(parsed->extension.empty()) << file;
    const auto turning = parsed->settings.find("turning");
    const std::string text = Written(
        *parsed,
        {"vase",
         {{1, 2, 3}, {4, 5, 3}},
         turning == parsed->settings.end() ? 0 : static_cast<int>(turning->second)});
    EXPECT_TRUE(text.ends_with(parsed->line_end)) << file;
    ++templates;
  }
  EXPECT_EQ(templates, 6);
}

TEST(PointProgram, TheIselTemplateWritesMicrometres) {
  const auto file = fs::path(INTAGLIO_SOURCE_DIR) / "deploy/post/isel.post";
  EXPECT_EQ(Written(Parsed(test::ContentOf(file)), {"vase", {{1.2344, -2, 0.0006}}}),
            "IMF_PBL_V1.0\r\n"
            "N1 ; vase, points: 1\r\n"
            "N2 FASTVEL 40000\r\n"
            "N3 SETPORT A1=00000000\r\n"
            "N4 FASTABS X1234 Y-2000 Z1\r\n"
            "N5 SETPORT A1=00000001\r\n"
            "N6 WAIT 10\r\n"
            "N7 SETPORT A1=00000000\r\n"
            "N8 SETPORT A1=00000000\r\n"
            "N9 PROGEND\r\n");
}

}  // namespace
}  // namespace intaglio::post
