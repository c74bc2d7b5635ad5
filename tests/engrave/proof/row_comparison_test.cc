// Rows of dots as a head burns them, with one fault each.

#include "engrave/proof/row_comparison.h"

#include <gtest/gtest.h>

namespace intaglio::proof {
namespace {

constexpr double kDotMm = 0.05, kPitchMm = 0.1, kTickMm = 0.01;
constexpr int kDots = 40;

double BeginOfDot(int dot) { return kPitchMm * dot; }

mark::MarkSet RowOfDots(std::uint32_t pass_count = 1) {
  mark::MarkSet set{{{"pen", 1000, 0.5, 0, pass_count, 0, 0}}, {{0, false, 0, {}}}};
  for (int i = 0; i < kDots; ++i) {
    set.marks[0].places.push_back({{BeginOfDot(i), 2}});
    set.marks[0].places.push_back({{BeginOfDot(i) + kDotMm, 2}, 0, i + 1 < kDots});
  }
  return set;
}

/// A dot of five ticks from there.
void BurnDot(double begin_mm, double aside_mm, std::vector<formats::BurntTick>& ticks) {
  for (int k = 1; k <= 5; ++k) {
    ticks.push_back(
        {ticks.size(), {begin_mm + k * kTickMm, 2 + aside_mm}, {kTickMm, 0}, 0.1, 1, 0});
  }
}

std::vector<formats::BurntTick> BurntRowOf(double shift_mm = 0) {
  std::vector<formats::BurntTick> ticks;
  for (int i = 0; i < kDots; ++i) BurnDot(BeginOfDot(i) + shift_mm, 0, ticks);
  return ticks;
}

TEST(RowComparison, APerfectRowIsMade) {
  const auto found = CompareMarks(RowOfDots(), BurntRowOf(), false);
  EXPECT_EQ(found.made_count, 1u);
  EXPECT_EQ(found.dot_count, std::uint64_t{kDots});
  EXPECT_EQ(found.wrong_dot_count, 0u);
  EXPECT_LT(found.worst.place_um, 1e-6);
  EXPECT_LT(found.worst.shape_um, 1e-6);
  EXPECT_NEAR(found.marks[0].pass_count, 1, 1e-9);
}

TEST(RowComparison, EachPassBelongsToTheSameDots) {
  auto ticks = BurntRowOf();
  EXPECT_EQ(CompareMarks(RowOfDots(2), ticks, false).wrong_dot_count,
            std::uint64_t{kDots});
  for (const formats::BurntTick& tick : BurntRowOf()) ticks.push_back(tick);
  EXPECT_EQ(CompareMarks(RowOfDots(2), ticks, false).made_count, 1u);
  EXPECT_EQ(CompareMarks(RowOfDots(1), ticks, false).doubled_count, 1u);
}

TEST(RowComparison, AMissingDotIsFoundWhereverItIs) {
  for (int missing = 0; missing < kDots; ++missing) {
    std::vector<formats::BurntTick> ticks;
    for (int i = 0; i < kDots; ++i)
      if (i != missing) BurnDot(BeginOfDot(i), 0, ticks);
    const auto found = CompareMarks(RowOfDots(), ticks, false);
    EXPECT_EQ(found.incomplete_count, 1u) << missing;
    EXPECT_GE(found.wrong_dot_count, 1u) << missing;
  }
}

TEST(RowComparison, ADotThatIsMadeTwiceOrInAGapIsFound) {
  for (int again = 0; again < kDots; ++again) {
    auto twice = BurntRowOf(), between = twice;
    BurnDot(BeginOfDot(again), 0, twice);
    EXPECT_EQ(CompareMarks(RowOfDots(), twice, false).doubled_count, 1u) << again;
    BurnDot(BeginOfDot(again) + kPitchMm / 2, 0, between);
    EXPECT_EQ(CompareMarks(RowOfDots(), between, false).made_count, 0u) << again;
  }
}

TEST(RowComparison, AMissingDotIsNotMadeUpForByAnother) {
  std::vector<formats::BurntTick> ticks;
  for (int i = 0; i < kDots; ++i)
    if (i != 7) BurnDot(BeginOfDot(i), 0, ticks);
  BurnDot(BeginOfDot(20), 0, ticks);
  EXPECT_EQ(CompareMarks(RowOfDots(), ticks, false).made_count, 0u);
}

TEST(RowComparison, AShiftIsOneOfTheRowAndADotAsideOneOfItsShape) {
  const auto shifted = CompareMarks(RowOfDots(), BurntRowOf(0.008), false);
  EXPECT_EQ(shifted.made_count, 1u);
  EXPECT_NEAR(shifted.worst.place_um, 8, 1e-6);
  EXPECT_LT(shifted.worst.shape_um, 1e-6);
  std::vector<formats::BurntTick> ticks;
  for (int i = 0; i < kDots; ++i)
    BurnDot(BeginOfDot(i) + (i == 11 ? 0.012 : 0), i == 30 ? 0.02 : 0, ticks);
  const auto aside = CompareMarks(RowOfDots(), ticks, false);
  EXPECT_EQ(aside.made_count, 1u);
  EXPECT_NEAR(aside.worst.shape_um, 20, 1);
  // On a web the whole row may lie anywhere.
  EXPECT_LT(CompareMarks(RowOfDots(), BurntRowOf(-250), true).worst.place_um, 1e-6);
  EXPECT_EQ(CompareMarks(RowOfDots(), BurntRowOf(-250), true).wrong_dot_count, 0u);
}

}  // namespace
}  // namespace intaglio::proof
