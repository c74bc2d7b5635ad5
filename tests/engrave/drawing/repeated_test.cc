#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <numbers>

#include "engrave/drawing/dxf/dxf_read.h"
#include "tests/engrave/drawing/dxf_text.h"
#include "tests/engrave/drawing/lengths.h"
#include "tests/sanitizers.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

constexpr double kTolerance_mm = 0.003;

std::size_t CountLeft(std::vector<FlatCurve> curves) {
  FlatDrawing flat{std::move(curves)};
  RemoveRepeatedContours(kTolerance_mm, flat);
  return flat.curves.size();
}
FlatCurve Square(double x, double side, double z = 0) {
  return {{{x, 0, z}, {x + side, 0, z}, {x + side, side, z}, {x, side, z}}, true};
}
/// Four hooks about the origin; `hand` -1 mirrors them. Box, area, length and second
/// moments of both are the same.
FlatCurve Pinwheel(double hand) {
  FlatCurve curve{{}, true};
  for (int i = 0; i < 4; ++i) {
    const double turn = i * pi / 2;
    for (const auto& [x, y] : {std::pair{1.0, 1.0}, {5.0, 1.0}, {5.0, 3.0}, {3.0, 3.0}}) {
      curve.points_mm.emplace_back(hand * (x * std::cos(turn) + y * std::sin(turn)),
                                   x * std::sin(turn) - y * std::cos(turn), 0);
    }
  }
  return curve;
}

TEST(RepeatedContours, FromAnyPointAndEitherWay) {
  FlatCurve turned = Square(0, 5);
  std::ranges::rotate(turned.points_mm, turned.points_mm.begin() + 1);
  FlatCurve back = turned;
  std::ranges::reverse(back.points_mm);
  back.layer = 7;
  FlatCurve divided = Square(0, 5);
  divided.points_mm.insert(divided.points_mm.begin() + 1, {2, 0.002, 0});
  EXPECT_EQ(CountLeft({Square(0, 5), turned, back, divided, Square(0, 5)}), 1U);
  // Where a number of the box is at the border of a cell, 64 tolerances.
  for (const double x : {0.0, 0.192, -0.192, 1.92}) {
    EXPECT_EQ(CountLeft({Square(x, 5), Square(x - 0.0029, 5)}), 1U) << x;
    EXPECT_EQ(CountLeft({Square(x, 5), Square(x + 0.0029, 5)}), 1U) << x;
  }
}

TEST(RepeatedContours, OthersStay) {
  EXPECT_EQ(CountLeft({Square(0, 5), Square(0.004, 5), Square(0, 5.01), Square(0, 5, 1)}),
            4U);
  EXPECT_EQ(CountLeft({Pinwheel(1), Pinwheel(-1), Pinwheel(1)}), 2U);
  FlatCurve open = Square(0, 5);
  open.closed = false;
  const FlatCurve point{{{0, 0, 0}}, false};
  EXPECT_EQ(CountLeft({open, open, point, point, Square(0, 5)}), 5U);
  EXPECT_EQ(CountLeft({}), 0U);
  EXPECT_EQ(CountLeft({Square(1e12, 1e12), Square(1e12, 1e12)}), 1U);
}

/// The contours of a drawing of these entities that even-odd filling uses.
std::size_t ContoursOf(const std::string& entities) {
  const auto drawing = ReadDxf(Entities(entities));
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  auto flat = Flatten(*drawing);
  JoinOpenCurves(0.001, *flat);
  RemoveRepeatedContours(kTolerance_mm, *flat);
  return flat->curves.size();
}

// A hatch and what it was drawn in, as programs write them.
TEST(RepeatedContours, HatchesAndTheirOutlines) {
  const std::string vertices = "10 0|20 0|10 9|20 0|42 0.4|10 9|20 5|10 0|20 5";
  EXPECT_EQ(
      ContoursOf("0 LWPOLYLINE|70 1|" + vertices + "|0 HATCH|91 1|92 3|" + vertices), 1U);
  const std::string lines =
      "0 LINE|10 0|20 0|11 4|21 0|0 LINE|10 4|20 3|11 4|21 0|0 LINE|10 4|20 3|11 0|21 0";
  EXPECT_EQ(ContoursOf("0 HATCH|8 h|91 1|92 2|10 4|20 3|10 0|20 0|10 4|20 0|" + lines),
            1U);
  // A circle as two bulges from another point, as an edge, and as itself.
  EXPECT_EQ(ContoursOf("0 CIRCLE|40 7.3|0 HATCH|91 1|92 2|10 0|20 7.3|42 1|10 0|20 "
                       "-7.3|42 1|0 HATCH|91 1|92 1|72 2|40 7.3|50 33|51 393|73 0"),
            1U);
}

TEST(RepeatedContours, ManyAlikeEndSoon) {
  std::vector<FlatCurve> same(200'000, Square(0, 5));
  EXPECT_EQ(CountLeft(std::move(same)), 1U);
  // The same but for their last part.
  std::vector<FlatCurve> alike;
  for (int i = 0; i < 200; ++i) {
    FlatCurve wave = Square(0, 5);
    for (int j = 0; j < 5000; ++j) {
      const double x = j < 4700 ? 0.4 * std::sin(j * 0.1) : 0.0035 * i;
      wave.points_mm.emplace_back(1 + x, 5 - j * 0.001, 0);
    }
    alike.push_back(std::move(wave));
  }
  // The processor's time counts: others may be busy.
  const std::clock_t begin = std::clock();
  EXPECT_EQ(CountLeft(std::move(alike)), 200U);
  EXPECT_LT(std::clock() - begin, 2 * test::kSanitizersTake * CLOCKS_PER_SEC);
}

}  // namespace
}  // namespace intaglio::drawing
