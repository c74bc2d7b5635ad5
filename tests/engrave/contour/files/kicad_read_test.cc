#include "engrave/contour/files/kicad_read.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/engrave/contour/files/kicad_text.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

KicadBoard BoardOf(const std::string& text) {
  auto board = ReadKicadBoard(text, "a.kicad_pcb");
  EXPECT_TRUE(board) << board.error().message;
  return board ? *board : KicadBoard{};
}

std::string RefusalOfBoard(const std::string& text, const KicadLimits& limits = {}) {
  const auto board = ReadKicadBoard(text, "a.kicad_pcb", limits);
  return board ? "no error" : board.error().message;
}

double AreaOfElements(const KicadBoard& board, std::uint32_t layer = 0) {
  const auto united = Unite(ElementsOfLayer(board, layer), {0, Corners::kRound});
  EXPECT_TRUE(united) << united.error().message;
  return united ? united->area_mm2 : -1;
}

/// One pad of a footprint that is turned by `degrees` about (10, 20).
KicadBoard PadBoard(const std::string& pad, double degrees = 0) {
  test::KicadText text;
  text.Net("A");
  text.Footprint("U1", 10, 20, degrees);
  text.Raw(pad);
  text.EndFootprint();
  return BoardOf(text.Text());
}

TEST(Kicad, ReadsTracksViasAndOutline) {
  test::KicadText text;
  text.Outline(0, 0, 40, 30);
  text.Segment(1, 2, 5, 2, 0.5, "A");
  text.Raw(
      " (arc (start 5 2) (mid 6 3) (end 5 4) (width 0.5) (layer \"B.Cu\") (net 1))\n");
  text.Via(5, 2, "A");
  const KicadBoard board = BoardOf(text.Text());
  EXPECT_THAT(board.layers, ElementsAre("F.Cu", "B.Cu"));
  ASSERT_EQ(board.elements.size(), 3U);
  const auto& track = std::get<Track>(board.elements[0].element.shape);
  EXPECT_LT((track.begin_mm - Vec2(1, -2)).norm() + (track.end_mm - Vec2(5, -2)).norm(),
            1e-12);
  EXPECT_EQ(board.elements[0].net, "A");
  EXPECT_FALSE(board.elements[0].terminal);
  const auto& arc = std::get<ArcTrack>(board.elements[1].element.shape).arc;
  EXPECT_LT((arc.center_mm - Vec2(5, -3)).norm(), 1e-9);
  EXPECT_NEAR(arc.length_mm, pi, 1e-9);
  EXPECT_EQ(board.elements[1].layers, 2U);
  EXPECT_EQ(board.elements[2].layers, 3U);
  EXPECT_TRUE(board.elements[2].terminal);
  ASSERT_EQ(board.holes.size(), 1U);
  EXPECT_NEAR(board.holes[0].diameter_mm, 0.4, 1e-12);
  ASSERT_EQ(board.outline.size(), 1U);
  EXPECT_NEAR(std::abs(AreaOf(board.outline[0])), 1200, 1e-9);
}

// KiCad's axis y points down and its angles run counter-clockwise on the screen: a
// footprint turned by 90 degrees has what was to its right above it.
TEST(Kicad, TurnsFootprintsAndPads) {
  const auto place = [](double degrees) {
    const KicadBoard board = PadBoard(
        "(pad \"1\" smd circle (at 3 1) (size 1 1) (layers \"F.Cu\") (net 1 \"A\"))",
        degrees);
    return std::get<Circle>(board.elements[0].element.shape).center_mm;
  };
  EXPECT_LT((place(0) - Vec2(13, -21)).norm(), 1e-9);
  EXPECT_LT((place(90) - Vec2(11, -17)).norm(), 1e-9);
  EXPECT_LT((place(180) - Vec2(7, -19)).norm(), 1e-9);
  // The angle of the pad is that on the board: an oval of 3 x 1 turned by 90 is upright.
  const KicadBoard oval = PadBoard(
      "(pad \"1\" smd oval (at 0 0 90) (size 3 1) (layers \"F.Cu\") (net 1 \"A\"))", 90);
  const auto& track = std::get<Track>(oval.elements[0].element.shape);
  EXPECT_NEAR(std::abs(track.end_mm.y() - track.begin_mm.y()), 2, 1e-9);
  EXPECT_EQ(oval.elements[0].element.name, "U1-1");
}

// Areas by hand.
TEST(Kicad, ReadsThePadShapes) {
  const auto area = [](const std::string& shape) {
    return AreaOfElements(
        PadBoard("(pad \"1\" smd " + shape + " (layers \"F.Cu\") (net 1 \"A\"))"));
  };
  EXPECT_NEAR(area("circle (at 0 0) (size 2 2)"), pi, 1e-5);
  EXPECT_NEAR(area("rect (at 0 0 30) (size 3 2)"), 6, 1e-5);
  EXPECT_NEAR(area("rect (at 0 0 90) (size 2 2)"), 4, 1e-5);
  EXPECT_NEAR(area("oval (at 0 0 12) (size 3 1)"), 2 + pi / 4, 1e-5);
  EXPECT_NEAR(area("roundrect (at 0 0 45) (size 3 2) (roundrect_rratio 0.25)"),
              6 - (4 - pi) * 0.25, 1e-5);
  EXPECT_NEAR(area("roundrect (at 0 0) (size 3 2) (roundrect_rratio 0.5)"), 2 + pi, 1e-5);
  EXPECT_NEAR(
      area("custom (at 0 0) (size 1 1) (options (clearance outline) (anchor rect))"
           " (primitives (gr_poly (pts (xy 0 0) (xy 4 0) (xy 4 3)) (width 0)))"),
      6 + 1 - 0.75 * 0.125, 1e-5);  // half the square is below the slope
  EXPECT_NEAR(area("rect (at 0 0) (size 1 1) (drill 0.5 (offset 2 0))"), 1, 1e-5);
}

TEST(Kicad, FillsZonesWithTheirCutIns) {
  test::KicadText text;
  text.Zone("GND",
            "(xy 0 0) (xy 10 0) (xy 10 10) (xy 0 10) (xy 0 5) (xy 4 5) (xy 4 6) (xy 6 6) "
            "(xy 6 4) (xy 4 4) (xy 4 5) (xy 0 5)");
  const KicadBoard board = BoardOf(text.Text());
  EXPECT_NEAR(AreaOfElements(board), 100 - 4, 1e-5);
  EXPECT_EQ(board.elements[0].net, "GND");
  test::KicadText open;
  open.Net("GND");
  open.Raw(
      " (zone (net 1) (net_name \"GND\") (layer \"F.Cu\") (polygon (pts (xy 0 0))))\n");
  const KicadBoard unfilled = BoardOf(open.Text());
  ASSERT_EQ(unfilled.findings.size(), 1U);
  EXPECT_EQ(unfilled.findings.begin()->what, "zone of net 'GND' that is not filled");
  EXPECT_EQ(unfilled.findings.begin()->effect, Effect::kLost);
}

TEST(Kicad, DrawsOutlinesOfZonesBeforeVersion6) {
  test::KicadText text;
  text.Net("GND");
  text.Raw(
      " (zone (net 1) (layer F.Cu) (min_thickness 0.5)\n (filled_polygon (pts (xy 0 0) "
      "(xy 10 0) (xy 10 10) (xy 0 10))))\n");
  // Grown by half the thickness: round corners.
  EXPECT_NEAR(AreaOfElements(BoardOf(text.Text())), 100 + 10 + pi / 16, 1e-5);
}

TEST(Kicad, ReadsGraphicsOnCopper) {
  test::KicadText text;
  text.Raw(
      " (gr_circle (center 0 0) (end 2 0) (layer \"F.Cu\") (width 0.2) (fill none))\n"
      " (gr_circle (center 9 0) (end 10 0) (layer \"F.Cu\") (width 0.2) (fill solid))\n"
      " (gr_poly (pts (xy 20 0) (xy 24 0) (xy 24 3)) (layer \"F.Cu\") (width 0) (fill "
      "solid))\n (gr_text \"x\" (at 0 0) (layer \"F.Cu\"))\n"
      " (gr_line (start 0 0) (end 9 9) (layer \"F.SilkS\") (width 1))\n");
  const KicadBoard board = BoardOf(text.Text());
  EXPECT_NEAR(AreaOfElements(board), 2 * pi * 2 * 0.2 + pi * 1.21 + 6, 1e-5);
  EXPECT_EQ(board.findings.CountOf("gr_text"), 1U);
}

// KiCad plots all of these on the copper; what is hidden or on other layers it does not.
TEST(Kicad, WhatIsNotReadOnCopperIsNamed) {
  test::KicadText text;
  text.Net("A");
  text.Raw(
      " (dimension (type aligned) (layer \"F.Cu\"))\n (image (at 1 1) (layer "
      "\"B.Cu\"))\n (table (layer \"F.Cu\"))\n (target plus (at 0 0) (layer "
      "\"B.SilkS\"))\n (generated (type tuning_pattern) (layer \"F.Cu\"))\n");
  text.Footprint("U1", 10, 20);
  text.Raw(
      "(layer \"F.Cu\") (fp_text user \"A\" (at 0 0) (layer \"F.Cu\"))"
      "(fp_text value \"B\" (at 0 0) (layer \"F.Cu\") hide)"
      "(property \"Value\" \"C\" (at 0 0) (layer \"F.Cu\") (hide yes))"
      "(property \"D\" \"D\" (at 0 0) (layer \"F.Cu\") (hide no))"
      "(fp_text_box \"E\" (layer \"F.Cu\"))");
  text.EndFootprint();
  std::vector<std::string> named;
  for (const FileFinding& finding : BoardOf(text.Text()).findings) {
    EXPECT_EQ(finding.effect, Effect::kLost);
    named.push_back(finding.what);
  }
  EXPECT_THAT(named, testing::UnorderedElementsAre("dimension", "image", "table",
                                                   "fp_text", "property", "fp_text_box"));
}

TEST(Kicad, ReadsDrillsOfAllKinds) {
  const KicadBoard board = PadBoard(
      "(pad \"1\" thru_hole oval (at 0 0) (size 3 2) (drill oval 2 1) (layers *.Cu) (net "
      "1 "
      "\"A\")) (pad \"\" np_thru_hole circle (at 5 0) (size 3 3) (drill 3) (layers "
      "*.Cu))");
  ASSERT_EQ(board.slots.size(), 1U);
  EXPECT_NEAR(std::get<Track>(board.slots[0].shape).width_mm, 1, 1e-12);
  ASSERT_EQ(board.holes.size(), 1U);
  EXPECT_NEAR(board.holes[0].diameter_mm, 3, 1e-12);
  EXPECT_EQ(board.elements.size(), 1U);
}

TEST(Kicad, JoinsTheOutlineOfArcsAndLines) {
  test::KicadText text;
  const std::string end = " (layer \"Edge.Cuts\") (width 0.1))\n";
  text.Raw(" (gr_line (start 1 0) (end 9 0)" + end);
  text.Raw(" (gr_arc (start 10 1) (mid 9.70710678 0.29289322) (end 9 0)" + end);
  text.Raw(" (gr_line (start 10 1) (end 10 8)" + end);
  text.Raw(" (gr_line (start 0 8) (end 10 8)" + end);
  text.Raw(" (gr_line (start 0 8) (end 0 1)" + end);
  text.Raw(" (gr_arc (start 1 1) (end 0 1) (angle 90)" + end);  // as before version 6
  text.Raw(" (gr_circle (center 5 4) (end 6 4)" + end);
  const KicadBoard board = BoardOf(text.Text());
  ASSERT_EQ(board.outline.size(), 2U);
  EXPECT_NEAR(std::abs(AreaOf(board.outline[0])), 80 - 2 * (1 - pi / 4), 1e-6);
  const auto region = RegionOfLoops(board.outline);
  ASSERT_TRUE(region) << region.error().message;
  EXPECT_NEAR(AreaOf(*region), 80 - 2 * (1 - pi / 4) - pi, 1e-6);
  test::KicadText open;
  open.Raw(" (gr_line (start 1 0) (end 9 0)" + end);
  EXPECT_THAT(RefusalOfBoard(open.Text()), HasSubstr("a contour is open at (9, 0)"));
}

TEST(Kicad, NamesFileLineAndRemedy) {
  EXPECT_THAT(RefusalOfBoard("(kicad_pcb (version 20211014)\n"),
              HasSubstr("a.kicad_pcb: line 2: a bracket is not closed"));
  EXPECT_THAT(RefusalOfBoard("(kicad_pcb \"a\n"), HasSubstr("line 1: an open string"));
  EXPECT_THAT(RefusalOfBoard(") (kicad_pcb)"), HasSubstr("expected a list"));
  EXPECT_THAT(RefusalOfBoard(""), HasSubstr("a bracket is not closed"));
  EXPECT_THAT(RefusalOfBoard("(kicad_pcb (version 4))"), HasSubstr("KiCad 5 or newer"));
  EXPECT_THAT(RefusalOfBoard("(kicad_pcb (version 20300101))"), HasSubstr("older KiCad"));
  EXPECT_THAT(RefusalOfBoard("(kicad_pcb (version 20211014))"), HasSubstr("no layers"));
  test::KicadText text;
  text.Raw(" (segment (start 0 0) (end 1 0) (width 1) (layer \"F.Cu\") (net 7))\n");
  EXPECT_THAT(RefusalOfBoard(text.Text()), HasSubstr("net 7 is not declared"));
  test::KicadText wrong;
  wrong.Raw(" (segment (start 0 x) (end 1 0) (width 1) (layer \"F.Cu\") (net 0))\n");
  EXPECT_THAT(RefusalOfBoard(wrong.Text()), HasSubstr("line 8: expected (start ..)"));
  EXPECT_THAT(RefusalOfBoard(wrong.Text(), {1 << 20, 30}), HasSubstr("more than 30"));
  EXPECT_THAT(RefusalOfBoard(std::string(500, '(')), HasSubstr("in each other"));
}

}  // namespace
}  // namespace intaglio::contour
