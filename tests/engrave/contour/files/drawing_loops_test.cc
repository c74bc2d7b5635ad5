#include "engrave/contour/files/drawing_loops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "engrave/contour/milling/cut.h"
#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/hpgl_read.h"
#include "engrave/drawing/svg/svg_read.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

Region RegionOf(const Result<drawing::Drawing>& drawing) {
  EXPECT_TRUE(drawing) << drawing.error().message;
  auto region = RegionOfDrawing(*drawing);
  EXPECT_TRUE(region) << region.error().message;
  return region ? *region : Region{};
}

const char kSvg[] =
    "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='60mm' "
    "viewBox='0 0 100 60'><rect x='10' y='10' width='80' height='40' fill='none' "
    "stroke='black'/><circle cx='30' cy='30' r='8'/><path d='M60 20 h20 v20 h-20 "
    "z'/></svg>";

// Circles stay arcs: the area is exact.
TEST(DrawingLoops, OfSvgKeepCircles) {
  const Region region = RegionOf(drawing::ReadSvg(kSvg));
  ASSERT_EQ(region.loops.size(), 3U);
  EXPECT_NEAR(AreaOf(region), 80 * 40 - pi * 64 - 400, 1e-6);
  const auto cuts = CutOut(region, {2});
  ASSERT_TRUE(cuts) << cuts.error().message;
  EXPECT_EQ(cuts->size(), 3U);
}

// As CAD programs write it: an outline of single lines and arcs in any order.
TEST(DrawingLoops, OfDxfJoinLinesAndArcs) {
  std::string text = "0\nSECTION\n2\nENTITIES\n";
  const auto line = [&](double ax, double ay, double bx, double by) {
    text += "0\nLINE\n8\n0\n10\n" + std::to_string(ax) + "\n20\n" + std::to_string(ay) +
            "\n11\n" + std::to_string(bx) + "\n21\n" + std::to_string(by) + "\n";
  };
  line(0, 0, 30, 0);
  line(30, 20, 0, 20);
  text += "0\nARC\n8\n0\n10\n30\n20\n10\n40\n10\n50\n270\n51\n90\n";
  line(0, 0, 0, 20);
  text += "0\nCIRCLE\n8\n0\n10\n30\n20\n10\n40\n4\n0\nENDSEC\n0\nEOF\n";
  drawing::ReadOptions options;
  options.unit_mm = 1;
  const Region region = RegionOf(drawing::ReadDxf(text, options));
  ASSERT_EQ(region.loops.size(), 2U);
  EXPECT_NEAR(AreaOf(region), 600 + pi * 50 - pi * 16, 1e-6);
}

TEST(DrawingLoops, OfHpglAreItsStrokes) {
  // 40 units a mm.
  const Region region =
      RegionOf(drawing::ReadHpgl("IN;SP1;PU0,0;PD400,0,400,800,0,800,0,0;PU;"));
  EXPECT_NEAR(AreaOf(region), 200, 1e-9);
}

// By the area of the ellipse, chords within 0.005 mm.
TEST(DrawingLoops, EllipsesBecomeChords) {
  const Region region = RegionOf(drawing::ReadSvg(
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='60mm' viewBox='0 0 "
      "100 60'><ellipse cx='50' cy='30' rx='20' ry='10'/></svg>"));
  ASSERT_EQ(region.loops.size(), 1U);
  EXPECT_GT(region.loops[0].size(), 20U);
  EXPECT_NEAR(AreaOf(region), pi * 200, 0.005 * LengthOf(region.loops[0]));
}

TEST(DrawingLoops, OpenContoursAreRefusedWithTheirPlace) {
  const auto drawing = drawing::ReadHpgl("IN;SP1;PU0,0;PD400,0,400,800;PU;");
  ASSERT_TRUE(drawing);
  const auto loops = LoopsOfDrawing(*drawing);
  ASSERT_FALSE(loops);
  EXPECT_THAT(loops.error().message, HasSubstr("a contour is open at (10, 20)"));
  EXPECT_THAT(LoopsOfDrawing(*drawing, {0, 0.01}).error().message,
              HasSubstr("the chord tolerance is 0"));
}

TEST(DrawingLoops, RepeatedLoopsAreKeptOnce) {
  const Region region = RegionOf(drawing::ReadHpgl(
      "IN;SP1;PU0,0;PD400,0,400,800,0,800,0,0;PU400,800;PD400,0,0,0,0,800,400,800;PU;"));
  EXPECT_EQ(region.loops.size(), 1U);
}

}  // namespace
}  // namespace intaglio::contour
