#include "engrave/proof/mark_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace intaglio::proof {
namespace {

/// A closed circle of 1 mm, its centre there.
mark::Mark Circle(const Vec2& centre_mm, double web_mm) {
  mark::Mark mark;
  mark.closed = true;
  mark.web_mm = web_mm;
  mark.places = {{centre_mm + Vec2(0.5, 0), 1}, {centre_mm - Vec2(0.5, 0), 1}};
  return mark;
}

mark::MarkSet ThreeCircles() {
  return {{{"pen", 500, 0.5, 0, 1, 0, 0}},
          {Circle({0, 0}, 0), Circle({2, 3}, 5), Circle({4, -3}, 10)}};
}

struct Burn {
  std::uint32_t mark = 0, run = 1;
  Vec2 centre_mm = Vec2::Zero();
  double radius_mm = 0.5, turns = 1, mj_mm = 2;
};

/// Chords of 5 um.
void BurnCircle(const Burn& burn, std::vector<formats::BurntTick>& ticks) {
  const double all_rad = 2 * std::numbers::pi * burn.turns;
  const int count = static_cast<int>(all_rad * burn.radius_mm / 0.005);
  const auto at = [&](int i) {
    const double rad = all_rad * i / count;
    return Vec2(burn.centre_mm + burn.radius_mm * Vec2(std::cos(rad), std::sin(rad)));
  };
  for (int i = 1; i <= count; ++i) {
    const Vec2 way = at(i) - at(i - 1);
    ticks.push_back(
        {ticks.size(), at(i), way, burn.mj_mm * way.norm(), burn.run, burn.mark});
  }
}

TEST(MarkComparison, PerfectMarksHaveNoErrors) {
  std::vector<formats::BurntTick> ticks;
  BurnCircle({.mark = 0, .centre_mm = {0, 0}}, ticks);
  BurnCircle({.mark = 1, .centre_mm = {-3, 3}}, ticks);
  BurnCircle({.mark = 2, .centre_mm = {-6, -3}}, ticks);
  const auto found = CompareMarks(ThreeCircles(), ticks, false);
  EXPECT_EQ(found.made_count, 3u);
  EXPECT_LT(found.worst.place_um, 0.1);
  EXPECT_LT(found.worst.shape_um, 0.2);
  EXPECT_LT(found.worst.gap_um, 0.1);
  EXPECT_LT(found.worst.diameter_um, 0.2);
  EXPECT_LT(found.worst.energy_ratio, 1e-9);
  EXPECT_NEAR(found.marks[1].energy_mj_mm, 2, 1e-9);
  EXPECT_TRUE(found.IsGood(1));
}

TEST(MarkComparison, EachErrorIsFoundAsLargeAsItWasMade) {
  std::vector<formats::BurntTick> ticks;
  BurnCircle({.mark = 0, .turns = 0.99}, ticks);
  BurnCircle({.mark = 1, .centre_mm = {-2.97, 3.04}}, ticks);
  BurnCircle({.mark = 2, .centre_mm = {-6, -3}, .radius_mm = 0.49, .mj_mm = 3}, ticks);
  const auto found = CompareMarks(ThreeCircles(), ticks, false);
  EXPECT_EQ(found.made_count, 3u);
  EXPECT_NEAR(*found.marks[0].gap_um, 1e3 * std::sin(0.01 * std::numbers::pi), 0.1);
  EXPECT_NEAR(found.worst.place_um, 50, 0.1);
  EXPECT_NEAR(*found.marks[2].diameter_um, -20, 0.1);
  EXPECT_NEAR(found.marks[2].shape_um, 10, 0.1);
  EXPECT_NEAR(found.worst.energy_ratio, 0.5, 1e-6);
  EXPECT_TRUE(found.IsGood(51));
  EXPECT_FALSE(found.IsGood(49));
}

TEST(MarkComparison, CountsWhatIsMissedIncompleteDoubledAndStray) {
  std::vector<formats::BurntTick> ticks;
  BurnCircle({.mark = 0, .turns = 0.5}, ticks);
  BurnCircle({.mark = 1, .centre_mm = {-3, 3}}, ticks);
  BurnCircle({.mark = 1, .run = 2, .centre_mm = {-3, 3}}, ticks);
  const std::size_t known = ticks.size();
  BurnCircle({.mark = 3, .centre_mm = {9, 9}}, ticks);
  const auto found = CompareMarks(ThreeCircles(), ticks, false);
  EXPECT_EQ(found.marks[0].fate, BurntFate::kIncomplete);
  EXPECT_EQ(found.marks[1].fate, BurntFate::kDoubled);
  EXPECT_EQ(found.marks[2].fate, BurntFate::kMissed);
  EXPECT_EQ(found.incomplete_count + found.doubled_count + found.missed_count, 3u);
  EXPECT_EQ(found.made_count, 0u);
  EXPECT_EQ(found.stray_tick_count, ticks.size() - known);
  EXPECT_FALSE(found.IsGood(1e6));
}

TEST(MarkComparison, ASecondPassIsNotADoubledMark) {
  auto set = ThreeCircles();
  set.marks.resize(1);
  set.pens[0].pass_count = 2;
  std::vector<formats::BurntTick> ticks;
  BurnCircle({}, ticks);
  EXPECT_EQ(CompareMarks(set, ticks, false).incomplete_count, 1u);
  BurnCircle({}, ticks);
  EXPECT_TRUE(CompareMarks(set, ticks, false).IsGood(1));
}

TEST(MarkComparison, TheWebsPlaceAtTheBeginOfARunIsNoError) {
  std::vector<formats::BurntTick> ticks;
  BurnCircle({.mark = 0, .run = 1, .centre_mm = {-60, 0}}, ticks);
  BurnCircle({.mark = 1, .run = 1, .centre_mm = {-63, 3}}, ticks);
  BurnCircle({.mark = 2, .run = 2, .centre_mm = {-26, -3.01}}, ticks);
  const auto found = CompareMarks(ThreeCircles(), ticks, true);
  EXPECT_EQ(found.made_count, 3u);
  // Across the web nothing is unknown.
  EXPECT_NEAR(found.worst.place_um, 10, 0.1);
  EXPECT_FALSE(CompareMarks(ThreeCircles(), ticks, false).IsGood(1e4));
}

TEST(MarkComparison, OpenMarksHaveNeitherGapNorDiameter) {
  mark::Mark line;
  line.places = {{{0, 0}, 0}, {{1, 0}, 0}, {{1, 1}, 0}};
  std::vector<formats::BurntTick> ticks;
  for (int i = 0; i < 200; ++i)
    ticks.push_back({static_cast<std::uint64_t>(i),
                     i < 100 ? Vec2(0.01 * (i + 1), 0.002) : Vec2(1, 0.01 * (i - 99)),
                     i < 100 ? Vec2(0.01, 0) : Vec2(0, 0.01), 0.02, 1, 0});
  const auto found =
      CompareMarks({{{"pen", 500, 0.5, 0, 1, 0, 0}}, {line}}, ticks, false);
  EXPECT_EQ(found.made_count, 1u);
  EXPECT_FALSE(found.marks[0].gap_um || found.marks[0].diameter_um);
  EXPECT_NEAR(found.marks[0].offset_mm.y(), 0.001, 1e-6);
  // A millimetre was burnt 2 um aside; the means are 1 um apart.
  EXPECT_NEAR(found.marks[0].shape_um, 1, 0.01);
}

/// Three repeats every 5 mm as planned, on a print that lies elsewhere: its marks are 2
/// mm before the origins that belong to them.
constexpr double kPrints[] = {-40, -45.3, -49.1};

MarkComparison OnPrints(const std::vector<Vec2>& origins_mm,
                        const std::vector<double>& prints_mm) {
  std::vector<formats::BurntTick> ticks;
  const Vec2 within[] = {{0, 0}, {2, 3}, {4, -3}};
  for (std::uint32_t i = 0; i < origins_mm.size(); ++i)
    BurnCircle({.mark = i, .centre_mm = origins_mm[i] + within[i]}, ticks);
  return CompareMarks(ThreeCircles(), ticks, PrintedRepeats{prints_mm, 5, -2});
}

TEST(MarkComparison, RepeatsAreComparedWithTheirPrintMarks) {
  const std::vector<double> prints(std::begin(kPrints), std::end(kPrints));
  const auto found = OnPrints({{-42, 0}, {-47.3, 0}, {-51.1, 0}}, prints);
  EXPECT_TRUE(found.IsGood(1)) << found.worst.place_um;
  EXPECT_EQ(found.shared_print_count, 0u);
  // By the pitch in their place each of them is wrong.
  const auto by_pitch = OnPrints({{-42, 0}, {-47, 0}, {-52, 0}}, prints);
  EXPECT_NEAR(1e3 * by_pitch.marks[1].offset_mm.x(), 300, 1);
  EXPECT_NEAR(1e3 * by_pitch.marks[2].offset_mm.x(), -900, 1);
  EXPECT_FALSE(by_pitch.IsGood(20));
}

TEST(MarkComparison, TwoRepeatsAtOnePrintMarkAreNamed) {
  const auto found = OnPrints({{-42, 0}, {-42, 0}, {-51.1, 0}},
                              {std::begin(kPrints), std::end(kPrints)});
  EXPECT_EQ(found.shared_print_count, 2u);
  EXPECT_LT(found.worst.place_um, 1);
  EXPECT_FALSE(found.IsGood(20));
}

}  // namespace
}  // namespace intaglio::proof
