#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/drawing/dxf/dxf_read.h"
#include "tests/engrave/drawing/dxf_text.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

// The groups before and behind the paths in files of AutoCAD: elevation, name of the
// pattern, then style, angle, lines of the pattern and seed points.
constexpr const char* kHead =
    "0 HATCH|8 cut|100 AcDbHatch|10 0|20 0|30 0|210 0|220 0|230 1|2 SOLID|70 1|71 0|";
constexpr const char* kTail = "|97 1|330 2F|75 1|76 1|98 1|10 3|20 2";

std::string Hatch(const std::string& paths) {
  return Entities(kHead + std::string("91 1|") + paths + kTail);
}
FlatDrawing FlatHatches(const std::string& text) {
  const auto drawing = ReadDxf(text);
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  if (!drawing) return {};
  auto flat = Flatten(*drawing);
  EXPECT_TRUE(flat.has_value());
  return flat ? *flat : FlatDrawing{};
}
/// The only contour of a hatch of these paths.
FlatCurve ContourOf(const std::string& paths) {
  const auto flat = FlatHatches(Hatch(paths));
  EXPECT_EQ(flat.curves.size(), 1U);
  if (flat.curves.size() != 1) return {PointList{Vec3::Zero()}};
  EXPECT_TRUE(flat.curves[0].closed);
  return flat.curves[0];
}
// Chords of 0.05 rad: lengths within 1.05e-4, areas of circles within 4.2e-4.
void ExpectLengthAndArea(const FlatCurve& curve, double length, double area) {
  EXPECT_NEAR(LengthOf(curve), length, length * 1.1e-4);
  EXPECT_NEAR(AreaOf(curve), area, std::abs(area) * 5e-4);
}

TEST(DxfHatch, VerticesWithBulges) {
  // Half circles of radius 2 on both ends of a rectangle of 10 x 4.
  ExpectLengthAndArea(
      ContourOf("92 7|72 1|73 1|93 4|10 0|20 0|42 0|10 10|20 0|42 1|10 10|20 4|42 0|"
                "10 0|20 4|42 1"),
      20 + 4 * pi, 40 + 4 * pi);
}

TEST(DxfHatch, ArcsRunBothWays) {
  // A rectangle of 10 x 4 with a half circle of radius 2 bitten out of its upper side:
  // clockwise from (7, 4) over (5, 2) to (3, 4).
  ExpectLengthAndArea(
      ContourOf("92 1|93 6|72 1|10 0|20 0|11 10|21 0|72 1|10 10|20 0|11 10|21 4|"
                "72 1|10 10|20 4|11 7|21 4|72 2|10 5|20 4|40 2|50 0|51 180|73 0|"
                "72 1|10 3|20 4|11 0|21 4|72 1|10 0|20 4|11 0|21 0"),
      10 + 4 + 3 + 2 * pi + 3 + 4, 40 - 2 * pi);
  // A sector from 60 degrees clockwise to 20: files store 360 minus the angle.
  const double x60 = 3 * std::cos(pi / 3), y60 = 3 * std::sin(pi / 3);
  const double x20 = 3 * std::cos(pi / 9), y20 = 3 * std::sin(pi / 9);
  ExpectLengthAndArea(
      ContourOf(fmt::format("92 1|93 3|72 1|10 0|20 0|11 {:.12f}|21 {:.12f}|"
                            "72 2|10 0|20 0|40 3|50 300|51 340|73 0|"
                            "72 1|10 {:.12f}|20 {:.12f}|11 0|21 0",
                            x60, y60, x20, y20)),
      6 + 3 * 2 * pi / 9, -0.5 * 9 * 2 * pi / 9);
  ExpectLengthAndArea(ContourOf("92 1|93 1|72 2|10 1|20 1|40 2|50 0|51 360|73 1"), 4 * pi,
                      4 * pi);
}

TEST(DxfHatch, EllipsesByParameter) {
  // The quarter of an ellipse with half axes 5 (along (3, 4)) and 2.5, and its two
  // halves of axes; at parameter 90 degrees the end of the short one.
  const std::string quarter =
      "72 3|10 1|20 1|11 3|21 4|40 0.5|50 0|51 90|73 1|72 1|10 -1|20 2.5|11 1|21 1|"
      "72 1|10 1|20 1|11 4|21 5";
  const double arc = DenseLength([](double t) {
    return Vec3(5 * std::cos(pi / 2 * t), 2.5 * std::sin(pi / 2 * t), 0);
  });
  ExpectLengthAndArea(ContourOf("92 1|93 3|" + quarter), arc + 7.5, 5 * 2.5 * pi / 4);
  // Clockwise from the short axis back: parameters 270 to 360, stored in the other
  // direction.
  const std::string back =
      "72 3|10 1|20 1|11 3|21 4|40 0.5|50 270|51 360|73 0|72 1|10 4|20 5|11 1|21 1|"
      "72 1|10 1|20 1|11 -1|21 2.5";
  ExpectLengthAndArea(ContourOf("92 1|93 3|" + back), arc + 7.5, -5 * 2.5 * pi / 4);
}

TEST(DxfHatch, Splines) {
  // A quarter circle as a rational quadratic; weights are between the points.
  ExpectLengthAndArea(
      ContourOf("92 1|93 3|72 4|94 2|73 1|74 0|95 6|96 3|40 0|40 0|40 0|40 1|40 1|40 1|"
                "10 2|20 0|42 1|10 2|20 2|42 0.70710678118654752|10 0|20 2|42 1|97 0|"
                "72 1|10 0|20 2|11 0|21 0|72 1|10 0|20 0|11 2|21 0"),
      4 + pi, pi);
  // The cubic of two fit points and tangents, x = 3 t^2 - 2 t^3, y = t (1 - t) (1 - 2 t)
  // with its chord; its loops are the same above and below.
  const double cubic = DenseLength([](double t) {
    return Vec3(3 * t * t - 2 * t * t * t, t * (1 - t) * (1 - 2 * t), 0);
  });
  EXPECT_NEAR(LengthOf(ContourOf(
                  "92 1|93 2|72 4|94 3|73 0|74 0|95 0|96 0|97 2|11 0|21 0|11 1|21 0|"
                  "12 0|22 1|13 0|23 1|72 1|10 1|20 0|11 0|21 0")),
              cubic + 1, 1.1e-4 * (cubic + 1));
}

TEST(DxfHatch, PathsLayersFramesAndWhatIsLeftOut) {
  const std::string square = "92 3|72 0|73 1|93 3|10 0|20 0|10 4|20 0|10 0|20 3";
  const auto drawing = ReadDxf(Entities(
      "0 HATCH|8 cut|62 3|10 0|20 0|30 2|210 0|220 0|230 -1|2 ANSI31|70 0|71 1|91 3|" +
      square +
      "|97 2|330 1|330 2|92 11|72 0|73 1|93 3|10 9|20 0|10 9|20 1|10 8|20 1|97 "
      "0|92 0|93 1|72 2|10 1|20 1|40 0.5|50 0|51 360|73 1|97 0|75 0|76 1|52 45|41 2|77 "
      "0|78 1|53 45|43 0|44 0|45 -2|46 2|79 0|98 1|10 7|20 7|0 HATCH|60 1|91 1|" +
      square));
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_EQ(drawing->findings.CountOf("pattern of a HATCH"), 1U);
  EXPECT_EQ(drawing->findings.CountOf("invisible"), 1U);
  const auto flat = Flatten(*drawing);
  ASSERT_EQ(flat->curves.size(), 2U);
  // Extrusion -z turns x over, and the elevation of 2 lies below.
  EXPECT_EQ(flat->curves[0].points_mm, (PointList{{0, 0, -2}, {-4, 0, -2}, {0, 3, -2}}));
  ExpectLengthAndArea(flat->curves[1], pi, -pi / 4);
  for (const Curve& curve : drawing->curves) {
    EXPECT_EQ(drawing->names[curve.layer], "cut");
    EXPECT_EQ(drawing->names[curve.color], "3");
  }
}

TEST(DxfHatch, EdgesInAnyOrderAreJoinedAsLinesOfADrawingAre) {
  auto flat =
      FlatHatches(Hatch("92 1|93 4|72 1|10 0|20 0|11 5|21 0|72 1|10 5|20 2|11 0|21 2|"
                        "72 1|10 5|20 2|11 5|21 0|72 1|10 0|20 0|11 0|21 2"));
  ASSERT_EQ(flat.curves.size(), 4U);
  JoinOpenCurves(0.001, flat);
  ASSERT_EQ(flat.curves.size(), 1U);
  EXPECT_TRUE(flat.curves[0].closed);
  EXPECT_NEAR(std::abs(AreaOf(flat.curves[0])), 10, 1e-12);
}

TEST(DxfHatch, InBlocksAHatchIsScaledAsOthersAre) {
  const std::string hatch = "0 HATCH|70 1|91 1|92 1|93 1|72 2|40 1|50 0|51 360|73 1";
  const auto flat = FlatHatches(
      WithBlocks("0 BLOCK|2 B|" + hatch + "|0 ENDBLK", "0 INSERT|2 B|41 3|42 2|10 9"));
  ASSERT_EQ(flat.curves.size(), 1U);
  EXPECT_NEAR(AreaOf(flat.curves[0]), 6 * pi, 6 * pi * 5e-4);
  EXPECT_NEAR(ExtentOf(flat).max_mm.x(), 12, 1e-12);
}

TEST(DxfHatch, BrokenAndEndlessOnesEndInErrors) {
  const auto error_of = [](const std::string& paths, std::uint64_t max_points,
                           std::uint64_t max_entities) {
    ReadOptions options;
    options.limits.max_points = max_points;
    options.limits.max_entities = max_entities;
    const auto drawing = ReadDxf(Hatch(paths), options, "a.dxf");
    return drawing ? Error{ErrorCode::kInvalidValue, "", ""} : drawing.error();
  };
  const Error spline = error_of("92 1|93 1|72 4|94 3|10 0|20 0", 99, 9);
  EXPECT_EQ(spline.code, ErrorCode::kInvalidValue);
  EXPECT_THAT(spline.message, ::testing::HasSubstr("a.dxf, line 5, HATCH"));
  EXPECT_EQ(error_of("92 3|10 x", 99, 9).value, "x");
  // Vertices, bulges and edges of all paths together.
  const std::string path = "92 2|10 0|20 0|42 1|10 1|20 0|42 1";
  EXPECT_EQ(error_of(path + "|" + path, 11, 9).code, ErrorCode::kTooLarge);
  const std::string edges = "92 1|72 1|11 1|72 1|11 2|72 1|11 3";
  EXPECT_EQ(error_of(edges, 8, 9).code, ErrorCode::kTooLarge);
  EXPECT_EQ(error_of(edges, 99, 3).code, ErrorCode::kTooLarge);
  EXPECT_EQ(error_of("92 0|92 0|92 0", 9, 2).code, ErrorCode::kTooLarge);
  // Nothing to draw: no radius, no vertex, an edge of no known type.
  EXPECT_EQ(error_of("92 1|72 2|40 0|72 7|10 1|92 2|92 1|92 65536|92 -1", 99, 9).message,
            "");
}

}  // namespace
}  // namespace intaglio::drawing
