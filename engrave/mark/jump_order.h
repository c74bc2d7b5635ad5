#pragma once

// The order of marks on a piece at rest, so that the ways between them are short.

#include "engrave/core/geometry.h"
#include "engrave/mark/mark.h"

namespace intaglio::mark {

struct JumpOrderOptions {
  Vec2 start_mm = Vec2::Zero();  ///< where the beam comes from
  /// Open marks may be made from their end to their beginning.
  bool may_reverse = true;
};

/// First always the nearest beginning (or, where it may, end) that is left; then parts of
/// up to 50 marks are reversed (2-opt) and marks moved within such a part (Or-opt) while
/// that shortens the way; closed marks begin at their place that is nearest to the one
/// before. Never longer than the marks as they are given. The marks themselves stay as
/// they are but for their direction and the first place of closed ones. N log N for marks
/// that are spread evenly.
std::vector<Mark> OrderByJumps(std::vector<Mark> marks, const JumpOrderOptions& options);

/// From the start through all marks in this order: the ways between them alone, mm.
double JumpLength(const std::vector<Mark>& marks, const Vec2& start_mm);

}  // namespace intaglio::mark
