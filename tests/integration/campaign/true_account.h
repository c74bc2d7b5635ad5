#pragma once

// The account of a job: what its machine really made, by the record of true places,
// against what the job asked for and what the journal says of it. One rule for points,
// contours and marks. Frame: of the record, mm.

#include <cstddef>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/formats/journal_file.h"

namespace intaglio::campaign {

/// One thing that a job makes: a point has one place, a closed contour repeats its first.
using Item = PointList;

/// A straight way on which the beam was on or the tool was in the work.
struct WorkPiece {
  Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();
  bool is_whole = false;  ///< it is a visit of its own, as each flash of a point is
};

struct Account {
  std::size_t items = 0;
  std::size_t made = 0;       ///< worked at all their places
  std::size_t doubled = 0;    ///< worked again, at more than the place where one closes
  std::size_t stray = 0;      ///< pieces of work beside every item
  double stray_mm = 0;        ///< the farthest of them
  std::size_t uncertain = 0;  ///< by the journal
  /// Items of which record and journal disagree, and the journal does not call uncertain.
  std::size_t unknown = 0;
};

/// Work within `near_mm` of an item is of this item.
Account AccountOf(const std::vector<Item>& items, const std::vector<WorkPiece>& work,
                  const formats::Journal& journal, double near_mm);

/// Sum of their ways; of pieces without one their number.
double AmountOf(const std::vector<WorkPiece>& work);

}  // namespace intaglio::campaign
