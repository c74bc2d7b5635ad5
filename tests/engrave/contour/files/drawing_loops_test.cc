#include "engrave/contour/files/drawing_loops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <numbers>
#include <random>

#include "engrave/contour/milling/cut.h"
#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/flatten.h"
#include "engrave/drawing/hpgl_read.h"
#include "engrave/drawing/svg/svg_read.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

Region RegionOf(const Result<drawing::Drawing>& drawing) {
  EXPECT_TRUE(drawing) << drawing.error().message;
  const auto loops = LoopsOfDrawing(*drawing);
  EXPECT_TRUE(loops) << loops.error().message;
  if (!loops) return {};
  auto region = RegionOfLoops(*loops);
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

// A closed polyline whose edges are shorter than what joins ends: it comes near to its
// start before it is back. Drawn twice it is one, in n log n.
TEST(DrawingLoops, TeethSmallerThanTheJointStayOneLoop) {
  for (const int teeth : {3, 40'000}) {
    drawing::Polyline line;
    for (int k = 0; k < teeth; ++k) {
      line.points_mm.emplace_back(k * 0.008, 0, 0);
      line.points_mm.emplace_back(k * 0.008 + 0.004, 0.008, 0);
    }
    line.points_mm.emplace_back(teeth * 0.008, 0, 0);
    line.points_mm.emplace_back(teeth * 0.008, -2, 0);
    line.points_mm.emplace_back(0, -2, 0);
    drawing::Drawing drawing;
    drawing.curves.resize(2);
    for (drawing::Curve& curve : drawing.curves) {
      curve.pieces.emplace_back(line);
      curve.closed = true;
    }
    const std::clock_t begin = std::clock();
    const Region region = RegionOf(drawing);
    ASSERT_EQ(region.loops.size(), 1U);
    EXPECT_NEAR(AreaOf(region), teeth * 0.008 * (2 + 0.004), 1e-6);
    // Some tenths on an idle machine; each edge with each other took a minute.
    EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 10);
  }
}

TEST(DrawingLoops, RepeatedLoopsAreKeptOnce) {
  const Region region = RegionOf(drawing::ReadHpgl(
      "IN;SP1;PU0,0;PD400,0,400,800,0,800,0,0;PU400,800;PD400,0,0,0,0,800,400,800;PU;"));
  EXPECT_EQ(region.loops.size(), 1U);
}

drawing::Curve ArcOfCircle(const Vec3& center, double radius, double begin,
                           double sweep) {
  drawing::EllipticArc arc;
  arc.center_mm = center;
  arc.axis_u_mm = Vec3(radius, 0, 0);
  arc.axis_v_mm = Vec3(0, radius, 0);
  arc.begin_rad = begin;
  arc.sweep_rad = sweep;
  return {{arc}};
}

drawing::Curve LineOf(const Vec3& from, const Vec3& to) {
  return {{drawing::Polyline{{from, to}}}};
}

// A slot of two lines and two arcs in any order and direction, a circle twice, and an
// open row of two lines.
TEST(DrawingCurves, AreJoinedAndKeepTheirArcs) {
  drawing::Drawing drawing;
  drawing.curves = {
      LineOf({10, 2, 0}, {0, 2, 0}),           ArcOfCircle({20, 20, 0}, 3, 0, 2 * pi),
      ArcOfCircle({10, 0, 0}, 2, pi / 2, -pi), LineOf({0, -10, 0}, {5, -10, 0}),
      ArcOfCircle({0, 0, 0}, 2, pi / 2, pi),   ArcOfCircle({20, 20, 0}, 3, 1, -2 * pi),
      LineOf({0, -2, 0}, {10, -2, 0}),         LineOf({5, -15, 0}, {5.004, -10, 0})};
  const auto curves = CurvesOfDrawing(drawing);
  ASSERT_TRUE(curves) << curves.error().message;
  ASSERT_EQ(curves->size(), 3U);
  EXPECT_TRUE((*curves)[0].closed);
  EXPECT_EQ((*curves)[0].edges.size(), 4U);
  EXPECT_NEAR(std::abs(AreaOf((*curves)[0].edges)), 40 + 4 * pi, 1e-9);
  EXPECT_TRUE((*curves)[1].closed);
  EXPECT_NEAR(LengthOf((*curves)[1].edges), 6 * pi, 1e-9);
  EXPECT_FALSE((*curves)[2].closed);
  // A line closes the gap of 4 um.
  EXPECT_EQ((*curves)[2].edges.size(), 3U);
  EXPECT_NEAR(LengthOf((*curves)[2].edges), 10, 0.005);
}

TEST(DrawingCurves, ThreeEndsAndOtherLayersAreNotJoined) {
  drawing::Drawing drawing;
  drawing.curves = {LineOf({0, 0, 0}, {5, 0, 0}), LineOf({5, 0, 0}, {9, 3, 0}),
                    LineOf({5, 0, 0}, {9, -3, 0}), LineOf({9, 3, 0}, {12, 3, 0})};
  drawing.curves[3].layer = 1;
  const auto curves = CurvesOfDrawing(drawing);
  ASSERT_TRUE(curves);
  EXPECT_EQ(curves->size(), 4U);
}

// Against the joining of chords (drawing::JoinOpenCurves): as many curves, as long.
TEST(DrawingCurves, AreThoseOfChords) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-50, 50);
  for (int trial = 0; trial < 40; ++trial) {
    drawing::Drawing drawing;
    for (int row = 0; row < 6; ++row) {
      const Vec3 begin(place(random), place(random), 0);
      Vec3 at = begin;
      const int parts = 1 + static_cast<int>(random() % 5);
      for (int k = 0; k < parts; ++k) {
        const bool back = k + 1 == parts && row % 2 == 0 && parts > 2;
        const Vec3 to = back ? begin : Vec3(place(random), place(random), 0);
        drawing.curves.push_back(random() % 2 == 0 ? LineOf(at, to) : LineOf(to, at));
        at = to;
      }
    }
    std::shuffle(drawing.curves.begin(), drawing.curves.end(), random);
    const auto curves = CurvesOfDrawing(drawing);
    ASSERT_TRUE(curves);
    auto flat = drawing::Flatten(drawing).value();
    drawing::JoinOpenCurves(0.01, flat);
    ASSERT_EQ(curves->size(), flat.curves.size());
    for (std::size_t i = 0; i < curves->size(); ++i) {
      const auto& points = flat.curves[i].points_mm;
      double length_mm = 0;
      for (std::size_t k = 0; k + (flat.curves[i].closed ? 0 : 1) < points.size(); ++k)
        length_mm += (points[(k + 1) % points.size()] - points[k]).norm();
      const Edges& edges = (*curves)[i].edges;
      EXPECT_EQ((*curves)[i].closed, flat.curves[i].closed);
      EXPECT_NEAR(LengthOf(edges), length_mm, 1e-6);
      for (std::size_t k = 1; k < edges.size(); ++k)
        ASSERT_EQ(edges[k].begin_mm, edges[k - 1].end_mm);
    }
  }
}

}  // namespace
}  // namespace intaglio::contour
