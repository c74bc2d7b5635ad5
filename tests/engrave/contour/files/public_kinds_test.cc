// Layers and drill files of the kinds that programs in the field read wrongly or refuse
// (tests/data/boards); the values are found by geometry and by the formats' definitions.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "engrave/contour/files/excellon_read.h"
#include "engrave/contour/files/gerber_read.h"
#include "engrave/contour/isolation.h"
#include "engrave/contour/union.h"
#include "tests/test_folder.h"

namespace intaglio::contour {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string DataOf(const std::string& name) {
  return intaglio::test::ContentOf(INTAGLIO_SOURCE_DIR "/tests/data/boards/" + name);
}

std::vector<Element> ElementsOfData(const std::string& name) {
  auto read = ReadGerber(DataOf(name), name);
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  return read.value_or(std::vector<Element>{});
}

double AreaOfText(const std::string& text) {
  const auto read = ReadGerber(text, "a.gbr");
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  if (!read) return 0;
  const auto united = Unite(*read, {0, Corners::kRound});
  EXPECT_TRUE(united) << (united ? "" : united.error().message);
  return united ? united->area_mm2 : 0;
}

std::vector<std::pair<double, double>> HolesOfData(const std::string& name) {
  const auto read = ReadExcellon(DataOf(name), name);
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  std::vector<std::pair<double, double>> places;
  if (!read) return places;
  for (const Hole& hole : read->holes)
    places.emplace_back(std::round(hole.center_mm.x() * 1e4) / 1e4,
                        std::round(hole.center_mm.y() * 1e4) / 1e4);
  return places;
}

TEST(PublicKinds, RegionsOfRoundedCorners) {
  EXPECT_NEAR(AreaOfText(DataOf("region_edge_1nm.gbr")), 200, 1e-4);
  EXPECT_NEAR(AreaOfText(DataOf("region_overshoot.gbr")), 50, 1e-4);
}

TEST(PublicKinds, RegionsThatTouchThemselves) {
  EXPECT_NEAR(AreaOfText(DataOf("region_pinched.gbr")), 200, 1e-4);
  const auto isolation = Isolate(ElementsOfData("region_pinched.gbr"), {0.2});
  ASSERT_TRUE(isolation) << isolation.error().message;
  EXPECT_EQ(isolation->piece_count, 1U);
  // A hole that touches the border in a corner, and a corner on a side.
  const std::string head = "%FSLAX46Y46*%%MOMM*%G01*G36*";
  EXPECT_NEAR(
      AreaOfText(head + "X0Y0D02*X10000000Y0D01*X10000000Y10000000D01*X0Y10000000D01*"
                        "X0Y0D01*X2000000Y4000000D01*X4000000Y2000000D01*X0Y0D01*G37*"
                        "M02*"),
      100 - 6, 1e-4);
  EXPECT_NEAR(
      AreaOfText(head + "X0Y0D02*X5000000Y0D01*X6000000Y5000000D01*X4000000Y5000000D01*"
                        "X5000000Y0D01*X10000000Y0D01*X10000000Y10000000D01*"
                        "X0Y10000000D01*X0Y0D01*G37*M02*"),
      100 - 5, 1e-4);
  // A line there and back, as layout programs leave among regions, shows nothing.
  EXPECT_NEAR(AreaOfText(head + "X0Y0D02*X250000Y0D01*Y0D01*X0Y0D01*D02*G37*G36*X0Y0D02*"
                                "X5000000Y0D01*X5000000Y4000000D01*X0Y0D01*G37*M02*"),
              10, 1e-4);
  // Without the last line, as one program writes them, and from the place before G36.
  EXPECT_NEAR(AreaOfText(head + "X0Y0D02*X5000000Y0D01*X5000000Y4000000D01*X0Y4000000D01*"
                                "G37*G36*X3000000Y6000000D01*Y4000000D01*G37*M02*"),
              20 + 3, 1e-4);
  // Edges that cross are none of these.
  EXPECT_FALSE(Unite(ReadGerber(head + "X0Y0D02*X10000000Y10000000D01*X10000000Y0D01*"
                                       "X0Y9000000D01*X0Y0D01*G37*M02*",
                                "a.gbr")
                         .value_or(std::vector<Element>{})));
}

TEST(PublicKinds, LegalForms) {
  EXPECT_NEAR(AreaOfText(DataOf("macro_line_of_no_length.gbr")), 0.36, 1e-9);
  EXPECT_NEAR(AreaOfText(DataOf("identity_offset_scale.gbr")),
              3.14159265358979 / 4 * 1.27 * 1.27, 1e-6);
  const std::string flash = "%ADD10C,1*%D10*X0Y0D03*M02*";
  EXPECT_NEAR(AreaOfText("%FSLAX46Y46*%%MOMM*%%ADD10R, 2.00 X 3*%D10*X0Y0D03*M02*"), 6,
              1e-6);
  // An arc in thousandths of an inch: its ends differ by 1.1 of them.
  EXPECT_TRUE(
      ReadGerber("%FSLAX23Y23*%%MOIN*%%ADD10C,0.013*%D10*G75*X3707Y3480D02*G03*"
                 "X3694Y3514I-47J0D01*M02*",
                 "a.gbr"));
  // The attributes in comments that EAGLE writes.
  EXPECT_NEAR(AreaOfText("G04 #@! %TF.Part,Single*\n%FSLAX46Y46*%%MOMM*%" + flash),
              0.7853982, 1e-6);
  // The unit behind the aperture; images that change nothing, and those that do.
  EXPECT_NEAR(AreaOfText("%FSLAX46Y46*%%ADD10C,1*%%MOMM*%D10*X0Y0D03*M02*"), 0.7853982,
              1e-6);
  for (const char* same : {"%MIA0B0*%", "%MIA0*%", "%IR0.0*%", "%SFA1.0B1*%", "%OFB0.0*%",
                           "%LR0.0*%", "%LS1.00*%"})
    EXPECT_NEAR(AreaOfText("%FSLAX46Y46*%%MOMM*%" + std::string(same) + flash), 0.7853982,
                1e-6);
  for (const char* other : {"%MIA1B0*%", "%IR90*%", "%SFA1.0B1.1*%", "%OFA0.1*%",
                            "%LR45*%", "%LS0.5*%", "%OFX0*%", "%IPNEG*%"}) {
    const auto read =
        ReadGerber("%FSLAX46Y46*%%MOMM*%" + std::string(other) + flash, "a.gbr");
    ASSERT_FALSE(read) << other;
    EXPECT_EQ(read.error().code, ErrorCode::kUnsupported);
  }
}

// Three squares on an exact grid were a write beyond the heap.
TEST(PublicKinds, SquaresOnAnExactGrid) {
  const auto isolation = Isolate(ElementsOfData("three_squares_crash.gbr"), {0.1});
  ASSERT_TRUE(isolation);
  EXPECT_EQ(isolation->passes[0].contours.size(), 3U);
}

TEST(PublicKinds, AGapAsWideAsTheTool) {
  for (const auto& [name, tool_mm] :
       {std::pair("gap_is_tool.gbr", 0.2), std::pair("gap_is_tool_inch.gbr", 0.254)}) {
    const auto isolation = Isolate(ElementsOfData(name), {tool_mm});
    ASSERT_TRUE(isolation) << isolation.error().message;
    EXPECT_EQ(isolation->net_count, 2U) << name;
    EXPECT_EQ(isolation->piece_count, 2U) << name;
    EXPECT_EQ(isolation->passes[0].contours.size(), 2U) << name;
  }
}

TEST(PublicKinds, OneNet) {
  const auto isolation = Isolate(ElementsOfData("same_net.gbr"), {0.2});
  ASSERT_TRUE(isolation) << isolation.error().message;
  EXPECT_EQ(isolation->piece_count, 2U);
}

TEST(PublicKinds, DigitsOfDrillFiles) {
  EXPECT_THAT(HolesOfData("format_4_4_lz.drl"),
              ElementsAre(std::pair(23.65, 15.0), std::pair(30.0, 15.0)));
  EXPECT_THAT(HolesOfData("format_2_3_tz.drl"),
              ElementsAre(std::pair(25.4, 25.4), std::pair(63.5, 25.4)));
  EXPECT_THAT(HolesOfData("no_zeros_declared.drl"),
              ElementsAre(std::pair(17.62, 65.245), std::pair(19.1211, 62.9945)));
}

TEST(PublicKinds, CommandsOfDrillFiles) {
  EXPECT_THAT(HolesOfData("zero_set_g93.drl"),
              ElementsAre(std::pair(10.0, 10.0), std::pair(20.0, 10.0)));
  EXPECT_THAT(
      HolesOfData("pattern_repeat.drl"),
      ElementsAre(std::pair(10.0, 10.0), std::pair(12.0, 10.0), std::pair(15.0, 10.0),
                  std::pair(17.0, 10.0), std::pair(20.0, 10.0), std::pair(22.0, 10.0)));
  const auto circle = ReadExcellon(DataOf("circle_g84.drl"), "a.drl");
  ASSERT_FALSE(circle);
  EXPECT_THAT(circle.error().message,
              AllOf(HasSubstr("a.drl: line 6"), HasSubstr("G84 would move holes")));
  const auto slots = ReadExcellon(DataOf("slots_only.drl"), "a.drl");
  ASSERT_TRUE(slots);
  EXPECT_EQ(slots->slots.size(), 1U);
}

// Every command of the language is obeyed, has no effect on holes, or is refused.
TEST(PublicKinds, NoCommandOfADrillFileIsSkippedInSilence) {
  const auto read_with = [](const std::string& command) {
    return ReadExcellon("M48\nMETRIC\nT1C0.8\n%\nT1\nX1.0Y1.0\n" + command + "\nM30\n",
                        "a.drl");
  };
  for (const char* command :
       {"G82X1.0Y1.0", "G83X1.0", "X1.0Y1.0G84X3.0", "G87X1.0", "G93X1.0Y0.0", "G92X1.0",
        "M70", "M80", "M90", "M02X1.0Y1.0", "M01", "G32X1.0A2.0", "G41", "X1.0Q5",
        "M25\nX2.0\nM01\nM02X1.0M80", "M25\nX2.0"}) {
    const auto read = read_with(command);
    ASSERT_FALSE(read) << command;
    EXPECT_THAT(read.error().message, HasSubstr("a.drl: line ")) << command;
  }
  for (const char* command : {"M47,text", "G40", "M09", "M06", "G04X1.0"}) {
    const auto read = read_with(command);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_TRUE(read->findings.empty()) << command;
    EXPECT_EQ(read->holes.size(), 1U) << command;
  }
  const auto unknown = read_with("M97\nM97");
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->findings.CountOf("M97"), 2U);
  EXPECT_EQ(unknown->findings.begin()->where, "line 7");
  EXPECT_EQ(unknown->findings.begin()->effect, Effect::kLost);
}

}  // namespace
}  // namespace intaglio::contour
