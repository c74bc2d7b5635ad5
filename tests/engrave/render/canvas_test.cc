#include "engrave/render/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio::render {
namespace {

const Paint kWhite{{1.0F, 1.0F, 1.0F}, 1.0F};

/// The light on the whole canvas, in white pixels.
double Light(const Canvas& canvas) {
  double sum = 0.0;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) sum += canvas.at(x, y).r;
  }
  return sum;
}

TEST(Canvas, IsBlackAndOfItsSize) {
  const Canvas canvas(7, 5);
  EXPECT_EQ(canvas.width(), 7);
  EXPECT_EQ(canvas.height(), 5);
  EXPECT_EQ(Light(canvas), 0.0);
  EXPECT_THROW(Canvas(0, 5), PreconditionError);
  EXPECT_THROW(Canvas(5, 20000), PreconditionError);
}

TEST(Canvas, SrgbIsLinearInside) {
  EXPECT_FLOAT_EQ(Srgb(0xFFFFFF).g, 1.0F);
  EXPECT_FLOAT_EQ(Srgb(0x000000).g, 0.0F);
  // IEC 61966-2-1: 0x80 is 21.59 % of the light.
  EXPECT_NEAR(Srgb(0x800000).r, 0.2159, 1e-4);
  EXPECT_EQ(Srgb(0x800000).b, 0.0F);
}

TEST(Canvas, ALineBetweenPixelCentresCoversWholePixels) {
  Canvas canvas(20, 20);
  DrawLine(canvas, {2.5, 10.5}, {17.5, 10.5}, 1.0, kWhite);
  EXPECT_FLOAT_EQ(canvas.at(10, 10).r, 1.0F);
  EXPECT_FLOAT_EQ(canvas.at(10, 9).r, 0.0F);
  EXPECT_FLOAT_EQ(canvas.at(10, 11).r, 0.0F);
  EXPECT_FLOAT_EQ(canvas.at(0, 10).r, 0.0F);
}

TEST(Canvas, LinesOfAnyDirectionHaveTheirArea) {
  for (const Vec2& to : {Vec2(90, 50), Vec2(50, 90), Vec2(85, 80), Vec2(12, 30)}) {
    Canvas canvas(100, 100);
    const Vec2 from(50, 50);
    DrawLine(canvas, from, to, 4.0, kWhite);
    // Length times width and two half discs; 3 %: coverage is taken at centres.
    const double area = (to - from).norm() * 4.0 + 3.14159 * 4.0;
    EXPECT_NEAR(Light(canvas), area, 0.03 * area);
  }
}

TEST(Canvas, DiscsAndPolygonsHaveTheirArea) {
  Canvas disc(60, 60);
  DrawDisc(disc, {30.2, 29.7}, 20.0, kWhite);
  EXPECT_NEAR(Light(disc), 3.14159 * 400, 5.0);
  EXPECT_FLOAT_EQ(disc.at(30, 30).r, 1.0F);

  for (const bool reverse : {false, true}) {
    Canvas polygon(60, 60);
    std::vector<Vec2> corners = {{10, 10}, {50, 10}, {30, 50}};
    if (reverse) std::reverse(corners.begin(), corners.end());
    FillConvex(polygon, corners, kWhite);
    EXPECT_NEAR(Light(polygon), 800.0, 8.0);
  }
}

TEST(Canvas, WhatLiesOutsideIsNotDrawn) {
  Canvas canvas(10, 10);
  DrawLine(canvas, {-1e6, -50}, {1e6, -40}, 3.0, kWhite);
  DrawDisc(canvas, {500, 500}, 5.0, kWhite);
  FillRect(canvas, {-5, -5, 3, 3}, kWhite);
  FillConvex(canvas, {{20, 20}, {30, 20}, {20, 30}}, kWhite);
  EXPECT_EQ(Light(canvas), 0.0);
  // A shape across the border is drawn as far as it is inside.
  FillRect(canvas, {8, -5, 10, 30}, kWhite);
  EXPECT_EQ(Light(canvas), 20.0);
}

TEST(Canvas, PaintCoversByItsShare) {
  Canvas canvas(4, 4);
  FillRect(canvas, {0, 0, 4, 4}, {{1, 0, 0}, 1.0F});
  FillRect(canvas, {0, 0, 4, 4}, {{0, 0, 1}, 0.25F});
  EXPECT_FLOAT_EQ(canvas.at(1, 1).r, 0.75F);
  EXPECT_FLOAT_EQ(canvas.at(1, 1).b, 0.25F);
}

TEST(Canvas, FrameIsOnePixelWide) {
  Canvas canvas(10, 10);
  FrameRect(canvas, {1, 1, 8, 6}, {{1, 1, 1}, 0.5F});
  EXPECT_FLOAT_EQ(canvas.at(1, 1).r, 0.5F);  // corners are painted once
  EXPECT_FLOAT_EQ(canvas.at(8, 6).r, 0.5F);
  EXPECT_FLOAT_EQ(canvas.at(2, 2).r, 0.0F);
  EXPECT_NEAR(Light(canvas), 0.5 * 24, 1e-6);
}

}  // namespace
}  // namespace intaglio::render
