#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/drawing/dxf/dxf_read.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

FlatCurve Open(PointList points, std::uint32_t layer = 0) {
  return {std::move(points), false, layer, 0};
}

TEST(JoinOpenCurves, LinesOfARectangleInAnyDirectionAndOrder) {
  FlatDrawing flat{{Open({{0, 0, 0}, {4, 0, 0}}), Open({{4, 3, 0}, {0, 3, 0}}),
                    Open({{4, 3, 0}, {4, 0, 0.0005}}), Open({{0, 0, 0}, {0, 3, 0}})}};
  JoinOpenCurves(0.001, flat);
  ASSERT_EQ(flat.curves.size(), 1U);
  EXPECT_TRUE(flat.curves[0].closed);
  EXPECT_EQ(flat.curves[0].points_mm.size(), 4U);
  EXPECT_NEAR(std::abs(AreaOf(flat.curves[0])), 12, 1e-9);
}

TEST(JoinOpenCurves, ThreeEndsAndOtherLayersStayApart) {
  const PointList a{{0, 0, 0}, {1, 0, 0}}, b{{1, 0, 0}, {2, 0, 0}},
      c{{1, 0, 0}, {1, 5, 0}};
  FlatDrawing star{{Open(a), Open(b), Open(c)}};
  JoinOpenCurves(0.001, star);
  EXPECT_EQ(star.curves.size(), 3U);
  FlatDrawing layers{{Open(a), Open(b, 1)}};
  JoinOpenCurves(0.001, layers);
  EXPECT_EQ(layers.curves.size(), 2U);
  FlatDrawing chain{{Open(b), Open(a)}};
  JoinOpenCurves(0.001, chain);
  ASSERT_EQ(chain.curves.size(), 1U);
  EXPECT_FALSE(chain.curves[0].closed);
  EXPECT_NEAR(LengthOf(chain.curves[0]), 2, 1e-12);
}

TEST(JoinOpenCurves, ClosedCurvesAndPointsAreKeptAsTheyAre) {
  FlatDrawing flat{{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, true, 0, 0},
                    Open({{0, 0, 0}}),
                    Open({{0, 0, 0}, {9, 0, 0}})}};
  JoinOpenCurves(0.001, flat);
  EXPECT_EQ(flat.curves.size(), 3U);
}

TEST(JoinOpenCurves, ArcThatComesBackWithinTheToleranceIsClosed) {
  PointList arc;
  for (int i = 0; i <= 100; ++i) {
    const double angle = 2 * std::numbers::pi * i / 100 * 0.9999;
    arc.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  FlatDrawing flat{{Open(arc)}};
  JoinOpenCurves(0.001, flat);
  ASSERT_EQ(flat.curves.size(), 1U);
  EXPECT_TRUE(flat.curves[0].closed);
}

}  // namespace
}  // namespace intaglio::drawing
