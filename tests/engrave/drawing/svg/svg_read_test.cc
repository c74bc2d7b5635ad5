#include "engrave/drawing/svg/svg_read.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/drawing/flatten.h"
#include "engrave/drawing/pieces.h"
#include "engrave/drawing/svg/svg_path.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

/// 100 x 80 mm, a user unit is a millimetre.
std::string Page(const std::string& content) {
  return "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='80mm' "
         "viewBox='0 0 100 80'>" +
         content + "</svg>";
}
FlatDrawing FlatSvg(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadSvg(text, options);
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  if (!drawing) return {};
  auto flat = Flatten(*drawing);
  EXPECT_TRUE(flat.has_value());
  return flat ? *flat : FlatDrawing{};
}
FlatDrawing PathOf(const std::string& d) {
  return FlatSvg(Page("<path d='" + d + "'/>"));
}
Error SvgError(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadSvg(text, options, "a.svg");
  EXPECT_FALSE(drawing.has_value());
  return drawing ? Error{} : drawing.error();
}
void ExpectPoints(const FlatCurve& curve, const PointList& points) {
  ASSERT_EQ(curve.points_mm.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT((curve.points_mm[i] - points[i]).norm(), 1e-9) << i;
  }
}

TEST(SvgRead, YIsTurnedOverOnThePage) {
  const auto flat = PathOf("M1,2 L3 4H5v6h-1V0");
  ASSERT_EQ(flat.curves.size(), 1U);
  ExpectPoints(flat.curves[0],
               {{1, 78, 0}, {3, 76, 0}, {5, 76, 0}, {5, 70, 0}, {4, 70, 0}, {4, 80, 0}});
}

TEST(SvgRead, NumbersWithoutBlanksRepeatedAndRelative) {
  const auto flat = PathOf("M10-.5.5.5-1e1,2m1 1l1,0 0,1zl2,0");
  ASSERT_EQ(flat.curves.size(), 3U);
  ExpectPoints(flat.curves[0], {{10, 80.5, 0}, {0.5, 79.5, 0}, {-10, 78, 0}});
  EXPECT_TRUE(flat.curves[1].closed);
  ExpectPoints(flat.curves[1], {{-9, 77, 0}, {-8, 77, 0}, {-8, 76, 0}});
  ExpectPoints(flat.curves[2], {{-9, 77, 0}, {-7, 77, 0}});
}

TEST(SvgRead, BeziersAndTheirSmoothForms) {
  const auto flat = PathOf("M0 0C0 10 10 10 10 0S20-10 20 0 M0 0Q5 10 10 0T20 0");
  ASSERT_EQ(flat.curves.size(), 2U);
  const double cubic = DenseLength([](double t) {
    return PointAt(CubicBezier{{Vec3(0, 0, 0), {0, 10, 0}, {10, 10, 0}, {10, 0, 0}}}, t);
  });
  EXPECT_NEAR(LengthOf(flat.curves[0]), 2 * cubic, cubic * 2.2e-4);
  const double quadratic = DenseLength([](double t) {
    return Vec3(2 * t * (1 - t) * 5 + t * t * 10, 2 * t * (1 - t) * 10, 0);
  });
  EXPECT_NEAR(LengthOf(flat.curves[1]), 2 * quadratic, quadratic * 2.2e-4);
}

// The arc must run from p to q on an ellipse of the given radii and turn, on the side and
// with the size that the flags select; both are checked from its points alone.
TEST(SvgRead, ArcsObeyTheirEndpointParameters) {
  const Vec3 p(3, 4, 0), q(9, 1, 0);
  for (const double turn : {0.0, 30.0, -75.0}) {
    for (const bool large : {false, true}) {
      for (const bool positive : {false, true}) {
        const Piece arc = SvgArc(p, q, {8, 5}, turn, large, positive);
        ASSERT_TRUE(std::holds_alternative<EllipticArc>(arc));
        const auto& a = std::get<EllipticArc>(arc);
        EXPECT_LT((PointAt(a, 0) - p).norm(), 1e-12);
        EXPECT_LT((PointAt(a, 1) - q).norm(), 1e-12);
        EXPECT_NEAR(a.axis_u_mm.norm(), 8, 1e-12);
        EXPECT_NEAR(a.axis_v_mm.norm(), 5, 1e-12);
        const double angle = turn * pi / 180;
        EXPECT_NEAR(a.axis_u_mm.x(), 8 * std::cos(angle), 1e-12);
        EXPECT_NEAR(a.axis_u_mm.y(), 8 * std::sin(angle), 1e-12);
        EXPECT_EQ(std::abs(a.sweep_rad) > pi, large);
        EXPECT_EQ(a.sweep_rad > 0, positive);
      }
    }
  }
}

TEST(SvgRead, ArcsWithRadiiTooSmallAreEnlargedAndFlatOnesAreLines) {
  const auto small = PathOf("M10 10a1 1 0 01.5.5M0 0A1 1 0 0 1 10 0M0 0A0 5 0 0 1 7 0");
  ASSERT_EQ(small.curves.size(), 3U);
  EXPECT_NEAR(LengthOf(small.curves[1]), 5 * pi, 5 * pi * 1.1e-4);
  ExpectPoints(small.curves[2], {{0, 80, 0}, {7, 80, 0}});
}

TEST(SvgRead, ShapesHaveTheirLengths) {
  const auto flat = FlatSvg(Page(
      "<circle cx='10' cy='20' r='5'/><rect x='1' y='2' width='30' height='20' rx='3'/>"
      "<ellipse rx='3' ry='3'/><line x1='1' x2='4' y2='4'/><rect width='3' height='4'/>"
      "<polyline points='0,0 3,4 6 8'/><polygon points='0 0 3 0 3 4'/><circle r='0'/>"));
  ASSERT_EQ(flat.curves.size(), 7U);
  const double wanted[] = {10 * pi, 2 * (24 + 14) + 6 * pi, 6 * pi, 5, 14, 10, 12};
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(LengthOf(flat.curves[i]), wanted[i], wanted[i] * 1.1e-4) << i;
    EXPECT_EQ(flat.curves[i].closed, i != 3 && i != 5) << i;
  }
}

TEST(SvgRead, TransformsAreAppliedFromTheInnermost) {
  const auto flat =
      FlatSvg(Page("<g transform='translate(10 20) rotate(90)'>"
                   "<path transform='scale(2,3)' d='M1 0L0 1'/></g>"
                   "<path transform='rotate(180 5 5)' d='M4 5L6 5'/>"
                   "<path transform='matrix(1 2 3 4 5 6)' d='M1 1L0 0'/>"));
  ASSERT_EQ(flat.curves.size(), 3U);
  ExpectPoints(flat.curves[0], {{10, 80 - 22, 0}, {7, 60, 0}});
  ExpectPoints(flat.curves[1], {{6, 75, 0}, {4, 75, 0}});
  ExpectPoints(flat.curves[2], {{9, 80 - 12, 0}, {5, 74, 0}});
}

TEST(SvgRead, UnitsOfThePage) {
  // No viewBox: user units are px of 1/96 inch.
  const auto px = FlatSvg("<svg width='96' height='1in'><line x2='96'/></svg>");
  ExpectPoints(px.curves[0], {{0, 25.4, 0}, {25.4, 25.4, 0}});
  ReadOptions options;
  options.unit_mm = 1;
  const auto one = FlatSvg("<svg width='96' height='1in'><line x2='96'/></svg>", options);
  ExpectPoints(one.curves[0], {{0, 96, 0}, {96, 96, 0}});
  const auto mixed = FlatSvg(Page("<line x1='10%' x2='5cm' y1='80px' y2='0'/>"));
  ASSERT_EQ(mixed.curves.size(), 1U);
  EXPECT_NEAR(mixed.curves[0].points_mm[0].x(), 10, 1e-9);
}

TEST(SvgRead, UsesSymbolsAndInnerPages) {
  const auto flat = FlatSvg(Page(
      "<defs><line id='a' x2='1'/><symbol id='s' viewBox='0 0 2 2'><line "
      "x2='2'/></symbol>"
      "</defs><use href='#a' x='5' y='6'/><use xlink:href='#s' width='10' height='10'/>"
      "<svg x='20' y='30' width='10' height='10' viewBox='0 0 5 5'><line "
      "x2='5'/></svg>"));
  ASSERT_EQ(flat.curves.size(), 3U);
  ExpectPoints(flat.curves[0], {{5, 74, 0}, {6, 74, 0}});
  ExpectPoints(flat.curves[1], {{0, 80, 0}, {10, 80, 0}});
  ExpectPoints(flat.curves[2], {{20, 50, 0}, {30, 50, 0}});
}

TEST(SvgRead, NamesAndWhatIsLeftOut) {
  const auto drawing = ReadSvg(Page(
      "<g id='g1' inkscape:label='Cut' style='stroke: #f00'><line x2='1'/></g>"
      "<text>t</text><image/><g display='none'><line x2='1'/></g><use href='#none'/>"));
  ASSERT_TRUE(drawing) << drawing.error().message;
  ASSERT_EQ(drawing->curves.size(), 1U);
  EXPECT_EQ(drawing->names[drawing->curves[0].layer], "Cut");
  EXPECT_EQ(drawing->names[drawing->curves[0].color], "#f00");
  EXPECT_EQ(drawing->findings.CountOf("text"), 1U);
  EXPECT_EQ(drawing->findings.CountOf("image"), 1U);
  EXPECT_EQ(drawing->findings.CountOf("invisible"), 1U);
}

// As browsers do: a line, or a point, is all that is left of them.
TEST(SvgRead, WhatATransformLeavesNoAreaOfIsNotDrawn) {
  const auto drawing = ReadSvg(Page(
      "<g transform='matrix(0 0 0 1 2 3)'><rect width='4' height='5'/></g>"
      "<circle r='2' transform='rotate(30) scale(1 0) rotate(7)'/>"
      "<line x2='1' transform='scale(0)'/><line x2='1' transform='scale(1 1e-4)'/>"));
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_EQ(drawing->curves.size(), 1U);
  EXPECT_EQ(drawing->findings.CountOf("invisible"), 3U);
}

// Browsers draw the rest of such files, and a path up to its error.
TEST(SvgRead, AWrongAttributeIsNamedAndDoesNotEndTheFile) {
  const auto drawing =
      ReadSvg(Page("\n<path id='p' d='M1 2 L3 4 L5 x'/><line x2='1'/>"), {}, "a.svg");
  ASSERT_TRUE(drawing) << drawing.error().message;
  ASSERT_EQ(drawing->curves.size(), 2U);
  ASSERT_EQ(drawing->findings.size(), 1U);
  EXPECT_EQ(drawing->findings.begin()->where, "line 2, path \"p\"");
  EXPECT_EQ(drawing->findings.begin()->effect, Effect::kChanged);
  EXPECT_THAT(drawing->findings.begin()->what, HasSubstr("attribute d"));
  for (const char* d : {"L1 2", "M", "M1", "Mnan 0", "M1e999 0", "M0 0 X",
                        "M0 0A1 1 0 2 0 1 1", "M0 0z1"}) {
    const auto wrong = ReadSvg(Page(fmt::format("<path d='{}'/><line x2='1'/>", d)));
    ASSERT_TRUE(wrong) << d;
    EXPECT_EQ(wrong->findings.size(), 1U) << d;
    EXPECT_GE(wrong->curves.size(), 1U) << d;
  }
  for (const char* element :
       {"<g transform='turn(5)'/>", "<circle r='5abc'/>", "<circle r='-5'/>",
        "<polyline points='1 2 3 4 x'/>", "<svg width='5abc'/>",
        "<rect x='9' width='1' height='1' transform='rotate(5)' transform-origin='x "
        "y'/>"}) {
    const auto wrong = ReadSvg(Page(element));
    ASSERT_TRUE(wrong) << element;
    EXPECT_EQ(wrong->findings.size(), 1U) << element;
  }
}

TEST(SvgRead, ErrorsNameThePlaceTheValueAndTheRemedy) {
  EXPECT_EQ(SvgError(Page("<path d='M1e300 0L2 2'/>")).code, ErrorCode::kInvalidValue);
  EXPECT_EQ(SvgError("").code, ErrorCode::kUnreadable);
  EXPECT_EQ(SvgError("<svg><g></svg>").code, ErrorCode::kUnreadable);
  EXPECT_EQ(SvgError("<html/>").code, ErrorCode::kUnreadable);
}

TEST(SvgRead, DeepEndlessAndLargeFilesEndInErrors) {
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<g>";
  for (int i = 0; i < 100'000; ++i) deep += "</g>";
  EXPECT_EQ(SvgError(Page(deep)).code, ErrorCode::kTooLarge);
  EXPECT_EQ(SvgError(Page("<g id='a'><use href='#a'/></g>")).code, ErrorCode::kTooLarge);
  std::string fan;
  for (int i = 0; i < 12; ++i) {
    fan += fmt::format("<g id='a{}'>", i);
    for (int j = 0; j < 10; ++j) fan += fmt::format("<use href='#a{}'/>", i + 1);
    fan += "</g>";
  }
  EXPECT_EQ(SvgError(Page(fan)).code, ErrorCode::kTooLarge);
  std::string many;
  for (int i = 0; i < 600'000; ++i) many += "<a/>";
  EXPECT_EQ(SvgError(Page(many)).code, ErrorCode::kTooLarge);
  ReadOptions options;
  options.limits.max_points = 5;
  EXPECT_EQ(SvgError(Page("<path d='M0 0h1h1h1h1h1h1h1'/>"), options).code,
            ErrorCode::kTooLarge);
}

// As a drawing program writes it: its own namespaces and metadata, a page in pixels
// whose user units are others, layers with transforms, styles as text.
TEST(SvgRead, FileOfADrawingProgram) {
  const auto flat =
      FlatSvg(FileText(INTAGLIO_SOURCE_DIR "/tests/data/drawings/layers.svg"));
  // A user unit is 4 / 3 px of 25.4 / 96 mm; the page is 1200 x 900 px.
  const double unit_mm = 4.0 / 3 * 25.4 / 96, height_mm = 900 * 25.4 / 96;
  const auto on_page = [&](double x, double y) {
    return Vec3(x * unit_mm, height_mm - y * unit_mm, 0);
  };
  ASSERT_EQ(flat.curves.size(), 4U);
  // The frame: its layer moves it by (30, 20).
  const Box3 box = ExtentOf(flat);
  EXPECT_LT((box.min_mm - on_page(40, 640)).norm(), 1e-9);
  EXPECT_LT((box.max_mm - on_page(860, 40)).norm(), 1e-9);
  EXPECT_NEAR(LengthOf(flat.curves[0]), 2 * (820 + 600) * unit_mm, 1e-9);
  // A circle of 50 in a layer that is twice as large: curves are cut into chords.
  EXPECT_TRUE(flat.curves[1].closed);
  EXPECT_NEAR(LengthOf(flat.curves[1]), 2 * pi * 100 * unit_mm, 0.1);
  // A triangle of 30, 40, 50, turned.
  EXPECT_NEAR(LengthOf(flat.curves[2]), 120 * unit_mm, 1e-9);
  // An open zigzag of four sides of 50.
  EXPECT_FALSE(flat.curves[3].closed);
  EXPECT_NEAR(LengthOf(flat.curves[3]), 200 * unit_mm, 1e-9);
}

// Viewers draw nothing beyond the page; a piece is made of the whole drawing.
TEST(SvgRead, WhatCrossesTheEdgeOfThePageIsWarnedOf) {
  const auto count = [](const std::string& page, const std::string& shape) {
    const auto drawing = ReadSvg("<svg xmlns='http://www.w3.org/2000/svg' " + page + ">" +
                                 shape + "</svg>");
    EXPECT_TRUE(drawing) << drawing.error().message;
    return drawing ? drawing->findings.CountOf("edge of the page") : 99;
  };
  const std::string page = "viewBox='10 20 100 50' width='30mm' height='15mm'";
  EXPECT_EQ(count(page, "<rect x='10' y='20' width='100' height='50'/>"), 0U);
  EXPECT_EQ(count(page, "<rect x='9' y='20' width='100' height='50'/>"), 1U);
  EXPECT_EQ(count(page, "<circle cx='60' cy='60' r='11'/>"), 1U);
  EXPECT_EQ(count(page, "<path d='M20 30C20 0 30 0 30 30'/>"), 1U);
  EXPECT_EQ(count(page + " overflow='visible'", "<circle cx='60' cy='60' r='11'/>"), 0U);
  EXPECT_EQ(count("", "<circle cx='600' cy='60' r='11'/>"), 0U) << "no page";
}

TEST(SvgRead, ClipsMasksAndTransformsOfThePageAreObeyedOrWarnedOf) {
  const std::string begin =
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='100mm' "
      "viewBox='0 0 100 100' ";
  const std::string end =
      "><clipPath id='c'><rect width='40' height='40'/></clipPath><mask id='m'/>"
      "<rect width='90' height='90'/></svg>";
  const auto clipped = ReadSvg(begin + "style='clip-path: url(#c)'" + end);
  ASSERT_TRUE(clipped) << clipped.error().message;
  ASSERT_EQ(clipped->curves.size(), 1U);
  const auto flat = Flatten(*clipped);
  Box3 box;
  for (const Vec3& p : flat->curves.at(0).points_mm) box.Extend(p);
  // The clip is in px of the page, outside of the viewBox.
  EXPECT_NEAR(box.size_mm().x(), 40 * 25.4 / 96, 1e-6);
  for (const char* property : {"mask", "filter"}) {
    const auto drawing = ReadSvg(begin + property + "='url(#m)'" + end);
    ASSERT_TRUE(drawing) << drawing.error().message;
    EXPECT_EQ(drawing->findings.CountOf(property), 1U);
  }
  const auto moved = ReadSvg(begin + "transform='scale(2)'" + end);
  ASSERT_TRUE(moved) << moved.error().message;
  EXPECT_EQ(moved->findings.CountOf("transform of the page"), 1U);
}

}  // namespace
}  // namespace intaglio::drawing
