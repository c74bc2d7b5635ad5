#include "engrave/discretize/spacing/interval_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace intaglio::discretize {
namespace {

std::vector<std::uint32_t> Items(const std::vector<IndexedInterval>& found) {
  std::vector<std::uint32_t> items;
  for (const IndexedInterval& f : found) items.push_back(f.item);
  return items;
}

std::vector<Interval> RandomIntervals(std::uint32_t count, std::uint32_t reach,
                                      std::mt19937& random) {
  std::vector<Interval> intervals;
  std::uniform_int_distribution<std::uint32_t> place(0, reach);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t first = place(random);
    // Intervals have all lengths, zero among them, from one to the reach.
    const std::uint32_t length = place(random) >> (random() % 32);
    intervals.push_back({first, std::min(reach, first + length)});
  }
  return intervals;
}

TEST(IntervalIndex, FindsWhatASearchOfAllFinds) {
  std::mt19937 random(1);
  for (const std::uint32_t reach : {1u, 7u, 100u, 100000u, kMaxIntervalEnd}) {
    const auto intervals = RandomIntervals(500, reach, random);
    const IntervalIndex index(intervals);
    std::vector<IndexedInterval> all;
    index.Find({0, kMaxIntervalEnd}, all);
    std::uniform_int_distribution<std::uint32_t> place(0, reach);
    for (int i = 0; i < 200; ++i) {
      const std::uint32_t a = place(random), b = place(random);
      const Interval range = {std::min(a, b), std::max(a, b)};
      std::vector<IndexedInterval> found, expected;
      index.Find(range, found);
      // In the order of the whole, whatever the range.
      for (const IndexedInterval& one : all) {
        const Interval& of = intervals[one.item];
        EXPECT_EQ(of.first, one.interval.first);
        EXPECT_EQ(of.end, one.interval.end);
        if (of.first < range.end && of.end > range.first && range.first < range.end) {
          expected.push_back(one);
        }
      }
      EXPECT_EQ(Items(found), Items(expected));
    }
    const auto filled = std::count_if(intervals.begin(), intervals.end(),
                                      [](const Interval& i) { return i.first < i.end; });
    EXPECT_EQ(all.size(), static_cast<std::size_t>(filled));
  }
}

TEST(IntervalIndex, OfNothingFindsNothing) {
  std::vector<IndexedInterval> found;
  IntervalIndex({}).Find({0, 10}, found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace intaglio::discretize
