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

/// Dots of 1 and gaps of 2 mm, along x.
Mark ThreeDots() {
  return {0,
          false,
          0,
          {{{0, 5}}, {{1, 5}, 0, true}, {{3, 5}}, {{4, 5}, 0, true}, {{6, 5}}, {{7, 5}}}};
}

TEST(Mark, ARowIsLitInItsDotsAlone) {
  EXPECT_TRUE(IsRow(ThreeDots()));
  EXPECT_FALSE(IsRow(Circle()));
  EXPECT_EQ(LengthOf(ThreeDots()), 7);
  EXPECT_EQ(LitLengthOf(ThreeDots()), 3);
  EXPECT_EQ(LitWayCount(ThreeDots()), 3U);
  const auto dots = LitWaysOf(ThreeDots(), 0.001);
  ASSERT_EQ(dots.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto x = 3 * static_cast<double>(i);
    EXPECT_EQ(dots[i], (std::vector<Vec2>{{x, 5}, {x + 1, 5}}));
  }
  EXPECT_EQ(LitWaysOf(Circle(), 0.01).size(), 1U);
  EXPECT_EQ(LitLengthOf(Circle()), LengthOf(Circle()));
}

TEST(Mark, DarkWaysAreOfStraightOpenRowsThatBeginAndEndLit) {
  const auto error_of = [](const Mark& mark) {
    const auto good = CheckMarks({{{"red", 100, 0.5}}, {mark}});
    return good ? std::string() : good.error().message;
  };
  EXPECT_EQ(error_of(ThreeDots()), "");
  Mark closed = ThreeDots();
  closed.closed = true;
  EXPECT_EQ(error_of(closed), "mark 0: it is closed and has a dark way");
  for (const std::size_t place : {0, 4, 5}) {
    Mark dark = ThreeDots();
    dark.places[place].dark = true;
    EXPECT_EQ(error_of(dark), "mark 0: it begins or ends with a dark way") << place;
  }
  Mark joined = ThreeDots();
  joined.places[2].dark = true;
  EXPECT_EQ(error_of(joined), "mark 0: two of its ways are dark, one behind the other");
  for (const Vec2& place : {Vec2(3, 5.001), Vec2(0.5, 5)}) {
    Mark bent = ThreeDots();
    bent.places[2].at_mm = place;
    EXPECT_EQ(error_of(bent), "mark 0: it has a dark way and does not go straight on");
  }
  EXPECT_EQ(error_of({0, false, 0, {{{0, 0}, 0, true}}}),
            "mark 0: it begins or ends with a dark way");
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
