#include "engrave/drawing/hpgl_read.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

FlatDrawing FlatOf(const std::string& text) {
  const auto drawing = ReadHpgl(text);
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  if (!drawing) return {};
  auto flat = Flatten(*drawing);
  return flat ? *flat : FlatDrawing{};
}
Error ErrorOf(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadHpgl(text, options, "a.plt");
  EXPECT_FALSE(drawing.has_value());
  return drawing ? Error{} : drawing.error();
}

TEST(HpglRead, PenMovesAbsoluteAndRelative) {
  const auto flat = FlatOf("IN;SP1;PU400,0;PD800,0,800 400;PR-400,0;PU;PA0,0;PD;PU;");
  ASSERT_EQ(flat.curves.size(), 2U);
  EXPECT_EQ(flat.curves[0].points_mm,
            (PointList{{10, 0, 0}, {20, 0, 0}, {20, 10, 0}, {10, 10, 0}}));
  EXPECT_EQ(flat.curves[1].points_mm, (PointList{{0, 0, 0}}));
}

TEST(HpglRead, LowerCaseWithoutSemicolonsAndControl) {
  const auto flat = FlatOf("\x1b.(\x1b%0Bin pu0,0pd400-400LBtext;PD9,9\x03sp2pa0 0");
  ASSERT_EQ(flat.curves.size(), 2U);
  EXPECT_EQ(flat.curves[0].points_mm, (PointList{{0, 0, 0}, {10, -10, 0}}));
  EXPECT_EQ(flat.curves[1].points_mm, (PointList{{10, -10, 0}, {0, 0, 0}}));
}

TEST(HpglRead, ArcsCirclesRectanglesAndWedges) {
  const auto flat = FlatOf(
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

TEST(HpglRead, PensAreLayersAndTheRestIsCounted) {
  const auto drawing = ReadHpgl("IN;SP3;PD40,0;PU;VS10;LBhello\x03;LBmore\x03;");
  ASSERT_TRUE(drawing);
  EXPECT_EQ(drawing->names[drawing->curves[0].layer], "SP3");
  EXPECT_EQ(drawing->left_out.at("LB"), 2U);
  EXPECT_EQ(drawing->left_out.at("VS"), 1U);
}

TEST(HpglRead, ErrorsNameThePlaceTheValueAndTheRemedy) {
  const Error odd = ErrorOf("IN;PD100;");
  EXPECT_EQ(odd.code, ErrorCode::kInvalidValue);
  EXPECT_THAT(odd.message, HasSubstr("a.plt, byte 3, PD"));
  EXPECT_EQ(ErrorOf("").code, ErrorCode::kUnreadable);
  EXPECT_EQ(ErrorOf("12345").code, ErrorCode::kUnreadable);
  EXPECT_EQ(ErrorOf("IN;P4").code, ErrorCode::kUnreadable);
  EXPECT_EQ(ErrorOf("IN;SC0,100,0,100;").code, ErrorCode::kUnsupported);
  EXPECT_EQ(ErrorOf("IN;PD1.2.3,4").code, ErrorCode::kInvalidValue);
  EXPECT_EQ(ErrorOf("IN;PD" + std::string(400, '9') + ",4").code,
            ErrorCode::kInvalidValue);
  EXPECT_EQ(ErrorOf("IN;CI;").code, ErrorCode::kInvalidValue);
  ReadOptions options;
  options.limits.max_points = 3;
  EXPECT_EQ(ErrorOf("PD1,1,2,2,3,3,4,4", options).code, ErrorCode::kTooLarge);
  options = {};
  options.limits.max_entities = 2;
  EXPECT_EQ(ErrorOf("CI1;CI1;CI1", options).code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::drawing
