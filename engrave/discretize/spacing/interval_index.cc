#include "engrave/discretize/spacing/interval_index.h"

#include <algorithm>
#include <bit>

#include "engrave/core/check.h"

// An interval no longer than 2^level lies in the cell [c 2^level, (c + 1) 2^level) that
// holds its beginning, or ends in the next: so those that meet a range are found, level
// by level, in the cells of the range and one before. Levels whose cells would be more
// than the intervals are not used; shorter intervals go to the lowest one that is.

namespace intaglio::discretize {

IntervalIndex::IntervalIndex(std::span<const Interval> intervals) {
  std::size_t count = 0;
  std::uint32_t longest = 0;
  for (const Interval& i : intervals) {
    if (i.first >= i.end) continue;
    Require(i.end <= kMaxIntervalEnd, "an interval ends at {}, above {}", i.end,
            kMaxIntervalEnd);
    ++count;
    end_ = std::max(end_, i.end);
    longest = std::max(longest, i.end - i.first);
  }
  if (count == 0) return;
  while ((end_ >> lowest_level_) > count) ++lowest_level_;
  const std::uint32_t levels = LevelOf({0, longest}) - lowest_level_ + 1;
  std::size_t cells = 0;
  for (std::uint32_t i = 0; i < levels; ++i) {
    level_cell_.push_back(cells);
    cells += (end_ >> (lowest_level_ + i)) + 1;
  }
  level_cell_.push_back(cells);
  // By counting sort: cell_end_ holds the beginnings until all intervals are stored.
  cell_end_.assign(cells + 1, 0);
  for (const Interval& i : intervals) {
    if (i.first < i.end) ++cell_end_[CellOf(i) + 1];
  }
  for (std::size_t c = 0; c < cells; ++c) cell_end_[c + 1] += cell_end_[c];
  sorted_.resize(count);
  for (std::uint32_t item = 0; item < intervals.size(); ++item) {
    const Interval& i = intervals[item];
    if (i.first < i.end) sorted_[cell_end_[CellOf(i)]++] = {item, i};
  }
}

std::uint32_t IntervalIndex::LevelOf(const Interval& interval) const {
  const auto level =
      static_cast<std::uint32_t>(std::bit_width(interval.end - interval.first - 1));
  return std::max(level, lowest_level_);
}

std::size_t IntervalIndex::CellOf(const Interval& interval) const {
  const std::uint32_t level = LevelOf(interval);
  return level_cell_[level - lowest_level_] + (interval.first >> level);
}

void IntervalIndex::Find(const Interval& range,
                         std::vector<IndexedInterval>& found) const {
  const std::uint32_t end = std::min(range.end, end_);
  if (range.first >= end) return;
  for (std::size_t i = 0; i + 1 < level_cell_.size(); ++i) {
    const auto level = static_cast<std::uint32_t>(lowest_level_ + i);
    const std::size_t first = range.first >> level, last = (end - 1) >> level;
    const std::size_t from = level_cell_[i] + (first > 0 ? first - 1 : 0);
    std::size_t at = from == 0 ? 0 : cell_end_[from - 1];
    for (; at < cell_end_[level_cell_[i] + last]; ++at) {
      const Interval& interval = sorted_[at].interval;
      if (interval.first < end && interval.end > range.first)
        found.push_back(sorted_[at]);
    }
  }
}

}  // namespace intaglio::discretize
