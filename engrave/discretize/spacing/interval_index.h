#pragma once

// Finds which of many intervals of integers meet a range without visiting the others: the
// triangles that some planes cut, or that reach into a slab.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace intaglio::discretize {

inline constexpr std::uint32_t kMaxIntervalEnd = 0x7fffffff;

/// first <= n < end, and end no more than kMaxIntervalEnd.
struct Interval {
  std::uint32_t first = 0;
  std::uint32_t end = 0;
};

struct IndexedInterval {
  std::uint32_t item = 0;  ///< its place in the list that was indexed
  Interval interval;
};

/// Memory is proportional to the number of intervals, whatever their lengths. The time of
/// Find is proportional to the intervals found, plus a few steps for each power of two
/// among the lengths.
class IntervalIndex {
 public:
  /// Empty intervals are left out.
  explicit IntervalIndex(std::span<const Interval> intervals);

  /// Appends those that meet the range. Their order among each other is always the same.
  void Find(const Interval& range, std::vector<IndexedInterval>& found) const;

  std::size_t size() const { return sorted_.size(); }

 private:
  std::uint32_t LevelOf(const Interval& interval) const;
  std::size_t CellOf(const Interval& interval) const;

  std::uint32_t lowest_level_ = 0;
  std::uint32_t end_ = 0;                // of all intervals
  std::vector<std::size_t> level_cell_;  // first cell of each level from the lowest on
  std::vector<std::uint32_t> cell_end_;  // in sorted_
  std::vector<IndexedInterval> sorted_;  // by cell, within it in the order given
};

}  // namespace intaglio::discretize
