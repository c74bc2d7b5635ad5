#include "engrave/drawing/hpgl_read.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

FlatDrawing FlatHpgl(const std::string& text) {
  const auto drawing = ReadHpgl(text);
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  if (!drawing) return {};
  auto flat = Flatten(*drawing);
  return flat ? *flat : FlatDrawing{};
}
Error HpglError(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadHpgl(text, options, "a.plt");
  EXPECT_FALSE(drawing.has_value());
  return drawing ? Error{} : drawing.error();
}

TEST(HpglRead, PenMovesAbsoluteAndRelative) {
  const auto flat = FlatHpgl("IN;SP1;PU400,0;PD800,0,800 400;PR-400,0;PU;PA0,0;PD;PU;");
  ASSERT_EQ(flat.curves.size(), 2U);
  EXPECT_EQ(flat.curves[0].points_mm,
            (PointList{{10, 0, 0}, {20, 0, 0}, {20, 10, 0}, {10, 10, 0}}));
  EXPECT_EQ(flat.curves[1].points_mm, (PointList{{0, 0, 0}}));
}

TEST(HpglRead, LowerCaseWithoutSemicolonsAndControl) {
  const auto flat = FlatHpgl("\x1b.(\x1b%0Bin pu0,0pd400-400LBtext;PD9,9\x03sp2pa0 0");
  ASSERT_EQ(flat.curves.size(), 2U);
  EXPECT_EQ(flat.curves[0].points_mm, (PointList{{0, 0, 0}, {10, -10, 0}}));
  EXPECT_EQ(flat.curves[1].points_mm, (PointList{{10, -10, 0}, {0, 0, 0}}));
}

TEST(HpglRead, ArcsCirclesRectanglesAndWedges) {
  const auto flat = FlatHpgl(
      "IN;PU400,0;PD;AA0,0,180;AR400,0,-90;PU0,0;CI200;EA400,200;RR400,200;EW400,30,90;");
  ASSERT_EQ(flat.curves.size(), 5U);
  EXPECT_NEAR(LengthOf(flat.curves[0]), 15 * pi, 15 * pi * 1.1e-4);
  // Half a circle about 0 to (-10, 0), then a quarter clockwise about 0: up to (0, 10).
  EXPECT_LT((flat.curves[0].points_mm.back() - Vec3(0, 10, 0)).norm(), 1e-9);
  EXPECT_NEAR(LengthOf(flat.curves[1]), 10 * pi, 10 * pi * 1.1e-4);
  EXPECT_NEAR(LengthOf(flat.curves[2]), 30, 1e-9);
  EXPECT_NEAR(LengthOf(flat.curves[3]), 30, 1e-9);
  EXPECT_NEAR(LengthOf(flat.curves[4]), 20 + 5 * pi, 5 * pi * 1.1e-4);
  for (std::size_t i = 1; i < 5; ++i) EXPECT_TRUE(flat.curves[i].closed) << i;
}

// The corners of the scale lie at the scaling points, in whichever order these are, and
// coordinates between them in proportion. 40 plotter units are a millimetre.
TEST(HpglRead, ScaleIsStretchedBetweenTheScalingPoints) {
  for (const char* kind : {"", ",0"}) {
    const auto flat = FlatHpgl(fmt::format(
        "IN;IP400,800,2400,1600;SC-1,1,0,100{};PU-1,0;PD1,100;PU0,25;PD0,0;PU;", kind));
    ASSERT_EQ(flat.curves.size(), 2U);
    EXPECT_EQ(flat.curves[0].points_mm, (PointList{{10, 20, 0}, {60, 40, 0}}));
    EXPECT_EQ(flat.curves[1].points_mm, (PointList{{35, 25, 0}, {35, 20, 0}}));
  }
  // Turned over, and from the right: both points and both ranges may fall.
  const auto turned =
      FlatHpgl("IP4000,0,0,4000;SC0,10,10,0;PU0,10;PD10,0;PR-5,5;PU;IP0,0;PA0,10;PD;PU;");
  ASSERT_EQ(turned.curves.size(), 2U);
  EXPECT_EQ(turned.curves[0].points_mm,
            (PointList{{100, 0, 0}, {0, 100, 0}, {50, 50, 0}}));
  // P1 alone takes P2 along, and the scale follows.
  EXPECT_EQ(turned.curves[1].points_mm, (PointList{{0, 0, 0}}));
}

// Kind 1: the largest equal unit that fits, the free room divided as given.
TEST(HpglRead, IsotropicScaleLeavesRoom) {
  struct Case {
    const char* scale;
    const char* far;
    Vec3 origin, end;
  };
  // 200 x 100 mm for 10 x 10 units: 10 mm each, 100 mm free beside; for 40 x 10: 5 mm
  // each, 50 mm free below and above. Of a range that falls the origin is at P2.
  for (const Case& c : {Case{"0,10,0,10,1", "10,10", {50, 0, 0}, {150, 100, 0}},
                        Case{"0,10,0,10,1,0,0", "10,10", {0, 0, 0}, {100, 100, 0}},
                        Case{"0,10,0,10,1,100,0", "10,10", {100, 0, 0}, {200, 100, 0}},
                        Case{"0,40,0,10,1,7,20", "40,10", {0, 10, 0}, {200, 60, 0}},
                        Case{"0,10,10,0,1,25", "10,10", {25, 100, 0}, {125, 0, 0}}}) {
    const auto flat =
        FlatHpgl(fmt::format("IP0,0,8000,4000;SC{};PU0,0;PD{};PU;", c.scale, c.far));
    ASSERT_EQ(flat.curves.size(), 1U) << c.scale;
    EXPECT_LT((flat.curves[0].points_mm[0] - c.origin).norm(), 1e-9) << c.scale;
    EXPECT_LT((flat.curves[0].points_mm[1] - c.end).norm(), 1e-9) << c.scale;
  }
}

TEST(HpglRead, ScaleByFactorAndItsEnd) {
  // A user unit is 40 plotter units, a millimetre; P1 is user point (5, 7).
  const auto flat = FlatHpgl(
      "IN;SC5,40,7,40,2;PU5,7;PD6,9;PU;IP400,400;PA5,7;PD;PU;"
      "SC;PA40,40;PD;PU;SC0,80,0,80,2;DF;PA80,40;PD;PU;IP9,9;SC0,80,0,80,2;IN;"
      "SC0,80,0,80,2;PA1,1;PD;PU;");
  ASSERT_EQ(flat.curves.size(), 5U);
  EXPECT_EQ(flat.curves[0].points_mm, (PointList{{0, 0, 0}, {1, 2, 0}}));
  EXPECT_EQ(flat.curves[1].points_mm, (PointList{{10, 10, 0}}));
  EXPECT_EQ(flat.curves[2].points_mm, (PointList{{1, 1, 0}}));
  EXPECT_EQ(flat.curves[3].points_mm, (PointList{{2, 1, 0}}));
  EXPECT_EQ(flat.curves[4].points_mm, (PointList{{2, 2, 0}}));
}

// A circle in user units is an ellipse on the page where x is stretched threefold.
TEST(HpglRead, ShapesInStretchedUnits) {
  const auto flat = FlatHpgl(
      "SC0,120,0,40,2;PU10,0;PD;AA0,0,180;PU0,0;CI2;EA1,1;ER2,1;EW2,0,90;"
      "PU0,1;PD;AR0,-1,-90;PU;");
  ASSERT_EQ(flat.curves.size(), 6U);
  const auto ellipse_mm = [](double a, double b, double from, double to) {
    return DenseLength([=](double t) {
      const double angle = from + t * (to - from);
      return Vec3(a * std::cos(angle), b * std::sin(angle), 0);
    });
  };
  const double wanted[] = {
      ellipse_mm(30, 10, 0, pi),       ellipse_mm(6, 2, 0, 2 * pi), 8, 14,
      8 + ellipse_mm(6, 2, 0, pi / 2), ellipse_mm(3, 1, 0, pi / 2)};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(LengthOf(flat.curves[i]), wanted[i], wanted[i] * 1.1e-4) << i;
  }
  EXPECT_LT((flat.curves[0].points_mm.back() - Vec3(-30, 0, 0)).norm(), 1e-9);
  EXPECT_LT((flat.curves[5].points_mm.back() - Vec3(3, 0, 0)).norm(), 1e-9);
}

TEST(HpglRead, ScalesThatMeanNothingAreErrors) {
  for (const char* text :
       {"SC0,1,0;", "SC0,1,0,1,3;", "SC0,1,0,1,0,5;", "SC0,1,0,1,1,5,5,5;", "IP1;",
        "IP1,2,3;", "IP0,0,9,9;SC1,1,0,1;", "IP0,0,9,9;SC0,1,2,2,1;", "SC0,0,0,1,2;",
        "IP0,0,0,9;SC0,1,0,1;", "IP0,0,9,9;SC0,1,0,1;IP9,9,9,10;"}) {
    EXPECT_EQ(HpglError(text + std::string("PA1,1")).code, ErrorCode::kInvalidValue)
        << text;
  }
  // The page is not in the file.
  for (const char* text : {"SC0,1,0,1,1;", "IR25,25,75,75;SC0,1,0,1,2;",
                           "IP0,0,9,9;SC0,1,0,1;IP;", "IP0,0,9,9;IN;SC0,1,0,1;"}) {
    for (const char* next : {"PA1,1", "CI1", "AR1,1,90", "EA1,1", "WG1,0,90"}) {
      EXPECT_EQ(HpglError(text + std::string(next)).code, ErrorCode::kUnsupported)
          << text << next;
    }
  }
  EXPECT_EQ(HpglError("SC0,1e300,0,1e300,2;PD9,9;PU").code, ErrorCode::kInvalidValue);
  EXPECT_EQ(HpglError("SC0,1e-320,0,1e-320,2;PD;AA1e300,1,90;PU").code,
            ErrorCode::kInvalidValue);
  // As long as nothing is drawn they do not matter.
  EXPECT_TRUE(ReadHpgl("SC0,1,0,1;IR1,1,9,9;IP0,0,9,9;PD1,1;PU;IR;SC;PA1,1;"));
}

TEST(HpglRead, PensAreLayersAndTheRestIsCounted) {
  const auto drawing = ReadHpgl("IN;SP3;PD40,0;PU;VS10;LBhello\x03;LBmore\x03;");
  ASSERT_TRUE(drawing);
  EXPECT_EQ(drawing->names[drawing->curves[0].layer], "SP3");
  EXPECT_EQ(drawing->findings.CountOf("LB"), 2U);
  EXPECT_EQ(drawing->findings.CountOf("VS"), 1U);
}

TEST(HpglRead, ErrorsNameThePlaceTheValueAndTheRemedy) {
  const Error odd = HpglError("IN;PD100;");
  EXPECT_EQ(odd.code, ErrorCode::kInvalidValue);
  EXPECT_THAT(odd.message, HasSubstr("a.plt, byte 3, PD"));
  EXPECT_EQ(HpglError("").code, ErrorCode::kUnreadable);
  EXPECT_EQ(HpglError("12345").code, ErrorCode::kUnreadable);
  EXPECT_EQ(HpglError("IN;P4").code, ErrorCode::kUnreadable);
  EXPECT_EQ(HpglError("IN;SC0,100,0,100;PU0,0;").code, ErrorCode::kUnsupported);
  EXPECT_EQ(HpglError("IN;PD1.2.3,4").code, ErrorCode::kInvalidValue);
  EXPECT_EQ(HpglError("IN;PD" + std::string(400, '9') + ",4").code,
            ErrorCode::kInvalidValue);
  EXPECT_EQ(HpglError("IN;CI;").code, ErrorCode::kInvalidValue);
  ReadOptions options;
  options.limits.max_points = 3;
  EXPECT_EQ(HpglError("PD1,1,2,2,3,3,4,4", options).code, ErrorCode::kTooLarge);
  options = {};
  options.limits.max_entities = 2;
  EXPECT_EQ(HpglError("CI1;CI1;CI1", options).code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::drawing
