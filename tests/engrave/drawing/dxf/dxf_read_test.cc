#include "engrave/drawing/dxf/dxf_read.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "tests/engrave/drawing/dxf_text.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

FlatDrawing FlatDxf(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadDxf(text, options);
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  if (!drawing) return {};
  auto flat = Flatten(*drawing);
  EXPECT_TRUE(flat.has_value());
  return flat ? *flat : FlatDrawing{};
}
Error DxfError(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadDxf(text, options, "a.dxf");
  EXPECT_FALSE(drawing.has_value());
  return drawing ? Error{} : drawing.error();
}

TEST(DxfRead, LineAndPoint) {
  const auto flat = FlatDxf(
      Entities("0 LINE|8 cut|62 3|10 1|20 2|30 3|11 4|21 6|31 3|0 POINT|10 7|20 8"));
  ASSERT_EQ(flat.curves.size(), 2U);
  EXPECT_EQ(flat.curves[0].points_mm, (PointList{{1, 2, 3}, {4, 6, 3}}));
  EXPECT_EQ(flat.curves[1].points_mm, (PointList{{7, 8, 0}}));
}

TEST(DxfRead, LayerAndColourAreNamed) {
  const auto drawing = ReadDxf(Entities("0 LINE|8 cut|62 3|11 1|0 POINT|8 cut|420 255"));
  ASSERT_TRUE(drawing);
  EXPECT_EQ(drawing->names[drawing->curves[0].layer], "cut");
  EXPECT_EQ(drawing->names[drawing->curves[0].color], "3");
  EXPECT_EQ(drawing->curves[0].layer, drawing->curves[1].layer);
  EXPECT_EQ(drawing->names[drawing->curves[1].color], "#0000ff");
}

// The default flattening keeps lengths within 1.05e-4: angle^2 / 24.
TEST(DxfRead, CircleAndArcLengths) {
  const auto flat =
      FlatDxf(Entities("0 CIRCLE|10 1|20 2|40 5|0 ARC|10 0|20 0|40 2|50 350|51 20|0 "
                       "ARC|40 1|50 90|51 90"));
  ASSERT_EQ(flat.curves.size(), 3U);
  EXPECT_TRUE(flat.curves[0].closed);
  EXPECT_NEAR(LengthOf(flat.curves[0]), 10 * pi, 10 * pi * 1.1e-4);
  EXPECT_NEAR(AreaOf(flat.curves[0]), 25 * pi, 25 * pi * 5e-4);
  EXPECT_NEAR(LengthOf(flat.curves[1]), 2 * pi / 6, 1.1e-4);
  const Vec3 begin(2 * std::cos(10 * pi / 180), -2 * std::sin(10 * pi / 180), 0);
  EXPECT_LT((flat.curves[1].points_mm.front() - begin).norm(), 1e-12);
  EXPECT_NEAR(LengthOf(flat.curves[2]), 2 * pi, 2 * pi * 1.1e-4);
}

TEST(DxfRead, ArcOfTurnedExtrusionIsMirrored) {
  // Extrusion -z: the arbitrary axis algorithm gives x = -x, y = y.
  const auto flat =
      FlatDxf(Entities("0 ARC|10 3|20 1|40 2|50 0|51 90|210 0|220 0|230 -1"));
  ASSERT_EQ(flat.curves.size(), 1U);
  EXPECT_LT((flat.curves[0].points_mm.front() - Vec3(-5, 1, 0)).norm(), 1e-12);
  EXPECT_LT((flat.curves[0].points_mm.back() - Vec3(-3, 3, 0)).norm(), 1e-12);
}

TEST(DxfRead, EllipseOfAnyTurn) {
  const auto flat = FlatDxf(
      Entities("0 ELLIPSE|10 1|20 1|11 3|21 4|40 0.25|41 0|42 6.283185307179586|"
               "0 ELLIPSE|11 5|21 0|40 0.5|41 1.5707963267948966|42 3.141592653589793"));
  ASSERT_EQ(flat.curves.size(), 2U);
  const double whole = DenseLength([](double t) {
    return Vec3(5 * std::cos(2 * pi * t), 1.25 * std::sin(2 * pi * t), 0);
  });
  EXPECT_TRUE(flat.curves[0].closed);
  EXPECT_NEAR(LengthOf(flat.curves[0]), whole, whole * 1.1e-4);
  EXPECT_LT((flat.curves[0].points_mm.front() - Vec3(4, 5, 0)).norm(), 1e-12);
  EXPECT_LT((flat.curves[1].points_mm.front() - Vec3(0, 2.5, 0)).norm(), 1e-9);
  EXPECT_LT((flat.curves[1].points_mm.back() - Vec3(-5, 0, 0)).norm(), 1e-9);
}

TEST(DxfRead, BulgesAreArcsToTheLeftOfTheirChord) {
  // A stadium: two straight sides of 10, two half circles of radius 2.
  const std::string vertices = "10 0|20 0|10 10|20 0|42 1|10 10|20 4|10 0|20 4|42 1";
  const auto flat = FlatDxf(Entities("0 LWPOLYLINE|90 4|70 1|38 2.5|" + vertices));
  ASSERT_EQ(flat.curves.size(), 1U);
  const double length = 20 + 4 * pi, area = 40 + 4 * pi;
  EXPECT_NEAR(LengthOf(flat.curves[0]), length, length * 1.1e-4);
  EXPECT_NEAR(AreaOf(flat.curves[0]), area, area * 5e-4);
  EXPECT_EQ(flat.curves[0].points_mm.front().z(), 2.5);
}

TEST(DxfRead, OldPolylineIsTheSameAsTheLightOne) {
  const auto old =
      FlatDxf(Entities("0 POLYLINE|66 1|70 1|10 0|20 0|30 2.5|0 VERTEX|10 0|20 0|0 "
                       "VERTEX|10 10|20 0|42 0.3|"
                       "0 VERTEX|10 10|20 4|42 -0.7|0 SEQEND|0 POINT|10 1"));
  const auto light = FlatDxf(Entities(
      "0 LWPOLYLINE|70 1|38 2.5|10 0|20 0|10 10|20 0|42 0.3|10 10|20 4|42 -0.7"));
  ASSERT_EQ(old.curves.size(), 2U);
  EXPECT_EQ(old.curves[0].points_mm, light.curves[0].points_mm);
  EXPECT_TRUE(old.curves[0].closed);
}

TEST(DxfRead, PolylineInSpaceAndMeshes) {
  const auto drawing = ReadDxf(Entities(
      "0 POLYLINE|70 8|0 VERTEX|10 1|20 2|30 3|0 VERTEX|10 4|20 5|30 6|42 1|0 SEQEND|"
      "0 POLYLINE|70 64|0 VERTEX|10 1|0 SEQEND|0 TEXT|1 hello"));
  ASSERT_TRUE(drawing);
  ASSERT_EQ(drawing->curves.size(), 1U);
  EXPECT_EQ(drawing->findings.CountOf("POLYLINE"), 1U);
  EXPECT_EQ(drawing->findings.CountOf("TEXT"), 1U);
  const auto flat = Flatten(*drawing);
  EXPECT_EQ(flat->curves[0].points_mm, (PointList{{1, 2, 3}, {4, 5, 6}}));
}

// A quarter circle as a rational quadratic: weights 1, cos 45 deg, 1.
TEST(DxfRead, RationalSplineIsACircle) {
  const auto flat = FlatDxf(Entities(
      "0 SPLINE|70 4|71 2|72 6|73 3|40 0|40 0|40 0|40 1|40 1|40 1|41 1|"
      "41 0.70710678118654752|41 1|10 2|20 0|30 1|10 2|20 2|30 1|10 0|20 2|30 1"));
  ASSERT_EQ(flat.curves.size(), 1U);
  for (const Vec3& p : flat.curves[0].points_mm) {
    EXPECT_NEAR(p.head<2>().norm(), 2, 1e-12);
    EXPECT_NEAR(p.z(), 1, 1e-12);
  }
  EXPECT_NEAR(LengthOf(flat.curves[0]), pi, pi * 1.1e-4);
}

// A cubic with uneven inner knots against the Cox-de Boor recursion written out.
double Basis(const std::vector<double>& knots, std::size_t i, int degree, double u) {
  if (degree == 0) return u >= knots[i] && u < knots[i + 1] ? 1 : 0;
  const auto p = static_cast<std::size_t>(degree);
  const double left = knots[i + p] - knots[i], right = knots[i + p + 1] - knots[i + 1];
  double sum = 0;
  if (left > 0) sum += (u - knots[i]) / left * Basis(knots, i, degree - 1, u);
  if (right > 0) {
    sum += (knots[i + p + 1] - u) / right * Basis(knots, i + 1, degree - 1, u);
  }
  return sum;
}

TEST(DxfRead, SplineLengthByTheRecursion) {
  const std::vector<double> knots{0, 0, 0, 0, 0.3, 0.9, 0.9, 2, 2, 2, 2};
  const PointList controls{{0, 0, 0}, {1, 3, 0}, {4, -2, 1}, {5, 5, 2},
                           {8, 0, 0}, {9, 1, 0}, {12, 0, 3}};
  std::string pairs = "0 SPLINE|71 3";
  for (const double knot : knots) pairs += fmt::format("|40 {}", knot);
  for (const Vec3& p : controls) {
    pairs += fmt::format("|10 {}|20 {}|30 {}", p.x(), p.y(), p.z());
  }
  const auto flat = FlatDxf(Entities(pairs));
  ASSERT_EQ(flat.curves.size(), 1U);
  const double length = DenseLength(
      [&](double t) {
        const double u = std::min(2 * t, 2 - 1e-12);
        Vec3 p = Vec3::Zero();
        for (std::size_t i = 0; i < controls.size(); ++i) {
          p += Basis(knots, i, 3, u) * controls[i];
        }
        return p;
      },
      20'000);
  EXPECT_NEAR(LengthOf(flat.curves[0]), length, length * 1.1e-4);
  EXPECT_LT((flat.curves[0].points_mm.back() - controls.back()).norm(), 1e-12);
}

TEST(DxfRead, SplineThroughFitPoints) {
  // Points of a circle, the first again at the end: the periodic spline stays round.
  std::string pairs = "0 SPLINE|70 1|71 3|74 17";
  for (int i = 0; i <= 16; ++i) {
    const double angle = 2 * pi * (i % 16) / 16;
    pairs += fmt::format("|11 {}|21 {}|31 0", 3 * std::cos(angle), 3 * std::sin(angle));
  }
  const auto flat = FlatDxf(Entities(pairs));
  ASSERT_EQ(flat.curves.size(), 1U);
  EXPECT_TRUE(flat.curves[0].closed);
  // h^4 / 384 of a circle of radius 3 with 16 chords: 3 * 0.39^4 / 384 = 2e-4 mm.
  for (const Vec3& p : flat.curves[0].points_mm) EXPECT_NEAR(p.norm(), 3, 1e-3);
}

TEST(DxfRead, FitPointsWithTangentsGiveTheCubicBack) {
  // Any single cubic whose parameter is the chord's: p(t), 0..1, chord 1, ends of
  // slope 1.
  const auto flat =
      FlatDxf(Entities("0 SPLINE|71 3|11 0|21 0|11 1|21 0|12 0|22 1|13 0|23 1"));
  ASSERT_EQ(flat.curves.size(), 1U);
  const double length = DenseLength([](double t) {
    return Vec3(3 * t * t - 2 * t * t * t, t * (1 - t) * (1 - t) - t * t * (1 - t), 0);
  });
  EXPECT_NEAR(LengthOf(flat.curves[0]), length, length * 1.1e-4);
}

TEST(DxfRead, BlocksAreScaledTurnedAndRepeated) {
  const std::string block = "0 BLOCK|2 B|10 1|20 0|0 LINE|10 1|20 0|11 2|21 1|0 ENDBLK";
  const auto flat = FlatDxf(
      WithBlocks(block, "0 INSERT|2 B|10 10|20 20|41 2|42 3|50 90|70 2|71 3|44 5|45 7"));
  ASSERT_EQ(flat.curves.size(), 6U);
  // Scaled (2, 3), turned by 90 degrees: the end lies at (-3, 2) from the insertion.
  EXPECT_LT((flat.curves[0].points_mm[0] - Vec3(10, 20, 0)).norm(), 1e-12);
  EXPECT_LT((flat.curves[0].points_mm[1] - Vec3(7, 22, 0)).norm(), 1e-12);
  // Columns go along the turned x, rows along the turned y.
  EXPECT_LT((flat.curves[5].points_mm[0] - Vec3(10 - 14, 25, 0)).norm(), 1e-12);
}

TEST(DxfRead, ArcInUnevenlyScaledBlocksIsAnEllipse) {
  const std::string blocks =
      "0 BLOCK|2 A|0 CIRCLE|40 1|0 ENDBLK|0 BLOCK|2 B|0 INSERT|2 A|41 3|0 ENDBLK";
  const auto flat = FlatDxf(WithBlocks(blocks, "0 INSERT|2 B|50 30|42 2"));
  ASSERT_EQ(flat.curves.size(), 1U);
  const double length = DenseLength([](double t) {
    return Vec3(3 * std::cos(2 * pi * t), 2 * std::sin(2 * pi * t), 0);
  });
  EXPECT_NEAR(LengthOf(flat.curves[0]), length, length * 1.1e-4);
}

TEST(DxfRead, UnitsOfTheFileAndOfTheCaller) {
  const std::string head = Groups("0 SECTION|2 HEADER|9 $INSUNITS|70 1|0 ENDSEC");
  const std::string line = Entities("0 LINE|10 0|11 2");
  EXPECT_EQ(FlatDxf(head + line).curves[0].points_mm[1].x(), 50.8);
  EXPECT_EQ(FlatDxf(line).curves[0].points_mm[1].x(), 2);
  ReadOptions options;
  options.unit_mm = 10;
  EXPECT_EQ(FlatDxf(head + line, options).curves[0].points_mm[1].x(), 20);
  const std::string unknown = Groups("0 SECTION|2 HEADER|9 $INSUNITS|70 25|0 ENDSEC");
  EXPECT_EQ(DxfError(unknown + line).code, ErrorCode::kUnsupported);
  EXPECT_EQ(FlatDxf(unknown + line, options).curves[0].points_mm[1].x(), 20);
}

TEST(DxfRead, SheetsAndInvisibleAreLeftOut) {
  const auto drawing = ReadDxf(Entities("0 LINE|67 1|11 1|0 LINE|60 1|11 1|0 LINE|11 1"));
  ASSERT_TRUE(drawing);
  EXPECT_EQ(drawing->curves.size(), 1U);
  EXPECT_EQ(drawing->findings.CountOf("on a sheet"), 1U);
  EXPECT_EQ(drawing->findings.CountOf("invisible"), 1U);
}

TEST(DxfRead, ErrorsNameThePlaceTheValueAndTheRemedy) {
  const Error number = DxfError(Entities("0 LINE|10 1|20 zwei"));
  EXPECT_EQ(number.code, ErrorCode::kInvalidValue);
  EXPECT_THAT(number.message, HasSubstr("a.dxf, line 10, LINE"));
  EXPECT_EQ(number.value, "zwei");
  EXPECT_EQ(DxfError(Entities("0 LINE|10 nan")).code, ErrorCode::kInvalidValue);
  EXPECT_EQ(DxfError(Entities("0 LINE|10 1e300")).code, ErrorCode::kInvalidValue);
  EXPECT_EQ(DxfError("").code, ErrorCode::kUnreadable);
  EXPECT_EQ(DxfError("not a drawing\nat all\n").code, ErrorCode::kUnreadable);
  EXPECT_EQ(DxfError("0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n").code,
            ErrorCode::kUnreadable);
  EXPECT_THAT(DxfError("0\nSECTION\n2\nENTITIES\n0\nLINE\n").message,
              HasSubstr("truncated"));
  EXPECT_EQ(DxfError("AutoCAD Binary DXF\r\n").code, ErrorCode::kUnreadable);
  EXPECT_EQ(DxfError("AC1018\n").code, ErrorCode::kUnsupported);
  EXPECT_EQ(DxfError(Entities("0 INSERT|2 X")).code, ErrorCode::kNotFound);
  EXPECT_EQ(DxfError(Entities("0 SPLINE|71 3|10 1|20 1")).code, ErrorCode::kInvalidValue);
  EXPECT_EQ(DxfError(Entities("0 SPLINE|72 2000000000|71 1000000")).code,
            ErrorCode::kInvalidValue);
}

TEST(DxfRead, BlocksWithoutEndEndInErrors) {
  const Error loop = DxfError(
      WithBlocks("0 BLOCK|2 A|0 INSERT|2 B|0 ENDBLK|0 BLOCK|2 B|0 INSERT|2 A|0 ENDBLK",
                 "0 INSERT|2 A"));
  EXPECT_EQ(loop.code, ErrorCode::kInvalidValue);
  EXPECT_THAT(loop.message, HasSubstr("contains itself"));

  // Ten blocks, each of ten of the next: ten thousand million insertions.
  std::string blocks;
  for (int i = 0; i < 10; ++i) {
    blocks += fmt::format("0 BLOCK|2 {}", i);
    for (int j = 0; j < 10; ++j) blocks += fmt::format("|0 INSERT|2 {}", i + 1);
    blocks += "|0 ENDBLK|";
  }
  EXPECT_EQ(DxfError(WithBlocks(blocks + "0 BLOCK|2 10|0 ENDBLK", "0 INSERT|2 0")).code,
            ErrorCode::kTooLarge);
  EXPECT_EQ(
      DxfError(WithBlocks("0 BLOCK|2 A|0 ENDBLK", "0 INSERT|2 A|70 1e9|71 1e9")).code,
      ErrorCode::kTooLarge);
}

TEST(DxfRead, LimitsAreThoseOfTheCaller) {
  const std::string text =
      Entities("0 LINE|11 1|0 LINE|11 2|0 LWPOLYLINE|10 1|10 2|10 3");
  ReadOptions options;
  options.limits.max_entities = 2;
  EXPECT_THAT(DxfError(text, options).message, HasSubstr("more than 2 entities"));
  options = {};
  options.limits.max_points = 6;
  EXPECT_THAT(DxfError(text, options).message, HasSubstr("more than 6 points"));
  options = {};
  options.limits.max_file_bytes = 20;
  EXPECT_EQ(DxfError(text, options).code, ErrorCode::kTooLarge);
}

TEST(DxfRead, LargeFilesEndSoon) {
  // A line of 60 MB, and a file of 60 MB of the smallest entities.
  std::string text = "0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n";
  text += std::string(60U << 20, '1') + "\n0\nENDSEC\n";
  EXPECT_EQ(DxfError(text).code, ErrorCode::kInvalidValue);
  text.resize(text.find("10\n1"));
  while (text.size() < (60U << 20)) text += "0\nLINE\n";
  EXPECT_EQ(DxfError(text + "0\nENDSEC\n").code, ErrorCode::kTooLarge);
}

TEST(DxfRead, RealFiles) {
  const std::string folder = INTAGLIO_SOURCE_DIR "/tests/data/";
  for (const char* name :
       {"trimesh/wrench.dxf", "trimesh/single_arc.dxf", "trimesh/spline.DXF",
        "trimesh/cycloidal.dxf", "broken/open_loop.dxf", "broken/loose_pair.dxf"}) {
    const auto flat = FlatDxf(FileText(folder + name));
    const Box3 box = ExtentOf(flat);
    EXPECT_FALSE(flat.curves.empty()) << name;
    EXPECT_TRUE(box.size_mm().allFinite()) << name;
    double length = 0;
    for (const FlatCurve& curve : flat.curves) length += LengthOf(curve);
    EXPECT_GT(length, box.size_mm().maxCoeff()) << name;
    std::printf("%s: %zu curves, %.3f x %.3f mm, %.3f mm of curve\n", name,
                flat.curves.size(), box.size_mm().x(), box.size_mm().y(), length);
  }
}

}  // namespace
}  // namespace intaglio::drawing
