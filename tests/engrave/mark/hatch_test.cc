#include "engrave/mark/hatch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

namespace intaglio::mark {
namespace {

using Contours = std::vector<std::vector<Vec2>>;

std::vector<Vec2> Star(const Vec2& middle, double radius_mm, int corners, bool clockwise,
                       std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.4, 1);
  std::vector<Vec2> star;
  for (int i = 0; i < corners; ++i) {
    const double t = 2 * std::numbers::pi * i / corners;
    star.push_back(middle + radius_mm * share(random) * Vec2(std::cos(t), std::sin(t)));
  }
  if (clockwise) std::reverse(star.begin(), star.end());
  return star;
}

/// By the sum of the angles under which a place sees the edges: no ray is cast.
int WindingAt(const Contours& contours, const Vec2& p, int& odd) {
  int winding = 0;
  odd = 0;
  for (const std::vector<Vec2>& contour : contours) {
    double sum = 0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const Vec2 a = contour[i] - p, b = contour[(i + 1) % contour.size()] - p;
      sum += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
    const int turns = static_cast<int>(std::lround(sum / (2 * std::numbers::pi)));
    winding += turns;
    odd += std::abs(turns);
  }
  return winding;
}

bool Inside(const Contours& contours, const Vec2& p, InsideRule rule) {
  int crossed = 0;
  const int winding = WindingAt(contours, p, crossed);
  return rule == InsideRule::kEvenOdd ? crossed % 2 == 1 : winding != 0;
}

double LengthOfAll(const std::vector<Chord>& chords) {
  double sum = 0;
  for (const Chord& chord : chords) sum += (chord.to_mm - chord.from_mm).norm();
  return sum;
}

/// A star with an island in it, one in the island, and a second star that overlaps.
Contours Islands(std::mt19937& random) {
  return {Star({0, 0}, 10, 13, false, random), Star({0, 0}, 3.5, 9, true, random),
          Star({0, 0}, 1.2, 5, false, random), Star({6, 3}, 5, 11, false, random)};
}

TEST(Hatch, EveryChordLiesInTheAreaAndNothingIsLeftOut) {
  std::mt19937 random(7);
  for (const InsideRule rule : {InsideRule::kEvenOdd, InsideRule::kNonZero}) {
    for (int k = 0; k < 6; ++k) {
      const Contours contours = Islands(random);
      HatchOptions options;
      options.rule = rule;
      options.distance_mm = 0.05;
      options.angle_rad = 0.7 * k;
      const auto chords = Hatch(contours, options);
      ASSERT_TRUE(chords);
      for (const Chord& chord : *chords)
        for (const double t : {1e-4, 0.3, 0.6, 1 - 1e-4})
          EXPECT_TRUE(
              Inside(contours, chord.from_mm + t * (chord.to_mm - chord.from_mm), rule));
      // The area by sampling; 40000 samples of a share of about a half: 0.25 % of the
      // square, 1 mm^2. Lines of a distance of 0.05 differ by less.
      std::uniform_real_distribution<double> place(-11, 11);
      int hits = 0;
      for (int i = 0; i < 40000; ++i)
        hits += Inside(contours, {place(random), place(random)}, rule) ? 1 : 0;
      const double area = 22.0 * 22.0 * hits / 40000;
      EXPECT_NEAR(LengthOfAll(*chords) * options.distance_mm, area, 4.5);
    }
  }
}

TEST(Hatch, LinesAreExactlyTheDistanceApart) {
  std::mt19937 random(3);
  for (const double angle : {0.0, 0.3, -1.2, 2.5}) {
    HatchOptions options;
    options.distance_mm = 0.37;
    options.angle_rad = angle;
    const auto chords = Hatch(Islands(random), options);
    ASSERT_TRUE(chords);
    const Vec2 across(-std::sin(angle), std::cos(angle));
    const double first = chords->front().from_mm.dot(across);
    std::set<long> lines;
    for (const Chord& chord : *chords) {
      const double k = (chord.from_mm.dot(across) - first) / options.distance_mm;
      EXPECT_NEAR(k, std::round(k), 1e-9);
      EXPECT_NEAR(chord.to_mm.dot(across), chord.from_mm.dot(across), 1e-9);
      lines.insert(std::lround(k));
    }
    // No line is left out: the stars are wider than a distance everywhere across.
    EXPECT_EQ(*lines.rbegin() - *lines.begin() + 1, static_cast<long>(lines.size()));
  }
}

const Contours kSquare = {{{0, 0}, {10, 0}, {10, 10}, {0, 10}}};

TEST(Hatch, LinesLieInTheMiddle) {
  HatchOptions options;
  options.distance_mm = 2.5;
  const auto chords = Hatch(kSquare, options);
  ASSERT_TRUE(chords);
  ASSERT_EQ(chords->size(), 4U);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR((*chords)[i].from_mm.y(), 1.25 + 2.5 * static_cast<double>(i), 1e-12);
  options.distance_mm = 30;
  const auto single = Hatch(kSquare, options);
  ASSERT_TRUE(single);
  ASSERT_EQ(single->size(), 1U);
  EXPECT_EQ(single->front().from_mm, Vec2(0, 5));
}

TEST(Hatch, EachNextLineComesBackUnlessOneWayIsAsked) {
  HatchOptions options;
  options.distance_mm = 1;
  const auto both = Hatch(kSquare, options);
  options.bidirectional = false;
  const auto one = Hatch(kSquare, options);
  ASSERT_TRUE(both && one);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_GT((*one)[i].to_mm.x(), (*one)[i].from_mm.x());
    EXPECT_EQ((*both)[i].to_mm.x() > (*both)[i].from_mm.x(), i % 2 == 0);
  }
}

TEST(Hatch, CrossRepeatsAtRightAngles) {
  HatchOptions options;
  options.distance_mm = 1;
  options.cross = true;
  const auto chords = Hatch(kSquare, options);
  ASSERT_TRUE(chords);
  ASSERT_EQ(chords->size(), 20U);
  for (std::size_t i = 10; i < 20; ++i)
    EXPECT_NEAR((*chords)[i].from_mm.x(), (*chords)[i].to_mm.x(), 1e-9);
}

TEST(Hatch, InsetShortensBothEnds) {
  HatchOptions options;
  options.distance_mm = 1;
  options.inset_mm = 0.25;
  const auto chords = Hatch(kSquare, options);
  ASSERT_TRUE(chords);
  for (const Chord& chord : *chords) {
    EXPECT_NEAR(std::min(chord.from_mm.x(), chord.to_mm.x()), 0.25, 1e-12);
    EXPECT_NEAR(std::max(chord.from_mm.x(), chord.to_mm.x()), 9.75, 1e-12);
  }
  options.inset_mm = 5;
  EXPECT_TRUE(Hatch(kSquare, options)->empty());
}

TEST(Hatch, ContoursThatShareAnEdgeAreOneArea) {
  const Contours pair = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                         {{1, 0}, {2, 0}, {2, 1}, {1, 1}}};
  for (const InsideRule rule : {InsideRule::kEvenOdd, InsideRule::kNonZero}) {
    HatchOptions options;
    options.distance_mm = 0.1;
    options.rule = rule;
    const auto chords = Hatch(pair, options);
    ASSERT_TRUE(chords);
    ASSERT_EQ(chords->size(), 10U);
    for (const Chord& chord : *chords)
      EXPECT_NEAR((chord.to_mm - chord.from_mm).norm(), 2, 1e-12);
  }
}

TEST(Hatch, RefusesWhatIsOutOfRange) {
  HatchOptions options;
  options.distance_mm = 0;
  EXPECT_EQ(Hatch(kSquare, options).error().code, ErrorCode::kInvalidValue);
  options.distance_mm = 1e-8;
  EXPECT_EQ(Hatch(kSquare, options).error().code, ErrorCode::kTooLarge);
  options.distance_mm = 1;
  options.inset_mm = -1;
  EXPECT_EQ(Hatch(kSquare, options).error().code, ErrorCode::kInvalidValue);
  options.inset_mm = 0;
  const Contours endless = {{{0, 0}, {1, 0}, {std::nan(""), 1}}};
  EXPECT_EQ(Hatch(endless, options).error().code, ErrorCode::kInvalidValue);
  EXPECT_TRUE(Hatch(Contours{{{0, 0}, {1, 1}}}, options)->empty());
}

}  // namespace
}  // namespace intaglio::mark
