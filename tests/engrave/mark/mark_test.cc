#include "engrave/mark/mark.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace intaglio::mark {
namespace {

/// Two half circles of radius 2.
Mark Circle() { return {0, true, 0, {{{2, 0}, 1}, {{-2, 0}, 1}}}; }

TEST(Mark, LengthFollowsItsArcs) {
  EXPECT_NEAR(LengthOf(Circle()), 4 * std::numbers::pi, 1e-12);
  EXPECT_EQ(LengthOf({0, false, 0, {{{0, 0}, 0}, {{3, 0}, 0}, {{3, 4}, 0}}}), 7);
  EXPECT_EQ(LengthOf({0, true, 0, {{{0, 0}, 0}, {{3, 0}, 0}, {{3, 4}, 0}}}), 12);
  EXPECT_EQ(LengthOf({0, false, 0, {{{1, 1}, 0}}}), 0);
}

TEST(Mark, ChordsKeepTheTolerance) {
  const std::vector<Vec2> places = PlacesOf(Circle(), 0.001);
  ASSERT_GT(places.size(), 50U);
  EXPECT_LT(places.size(), 150U);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_NEAR(places[i].norm(), 2, 1e-12);
    const Vec2 middle = (places[i] + places[(i + 1) % places.size()]) / 2;
    EXPECT_GE(middle.norm(), 2 - 0.001 - 1e-12);
  }
}

TEST(Mark, AQuarterTurnsCounterclockwiseWithAPositiveBulge) {
  const double bulge = std::tan(std::numbers::pi / 8);
  for (const Vec2& place : PlacesOf({0, false, 0, {{{1, 0}, bulge}, {{0, 1}, 0}}}, 0.01))
    EXPECT_NEAR(place.norm(), 1, 1e-12);
  for (const Vec2& place : PlacesOf({0, false, 0, {{{1, 0}, -bulge}, {{0, 1}, 0}}}, 0.01))
    EXPECT_NEAR((place - Vec2(1, 1)).norm(), 1, 1e-12);
}

TEST(Mark, WhatCannotBeMadeIsRefusedByNumber) {
  MarkSet set{{{"red", 100, 0.5}}, {Circle(), Circle()}};
  EXPECT_TRUE(CheckMarks(set));
  set.marks[1].pen = 1;
  EXPECT_EQ(CheckMarks(set).error().message, "mark 1: it has no pen");
  set.marks[1] = {0, false, 0, {}};
  EXPECT_EQ(CheckMarks(set).error().message, "mark 1: it has no place");
  set.marks[1] = Circle();
  set.marks[1].places[0].bulge = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CheckMarks(set).error().message, "mark 1: a value is not finite");
  set.pens[0].speed_mm_s = 0;
  EXPECT_EQ(CheckMarks(set).error().message, "pen 0: its speed is not above 0");
}

}  // namespace
}  // namespace intaglio::mark
