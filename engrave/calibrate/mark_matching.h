#pragma once

// Which measured mark is which mark of the pattern, when the measurement is turned and
// shifted against it: a block under a microscope, a scan. Similarity, no mirror image: a
// picture is taken from above, where the beam comes from.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::calibrate {

struct MatchOptions {
  /// How far a mark may be from its place after the best turn and shift; below half the
  /// smallest distance of two marks, or neighbours are taken for each other.
  double reach_mm = 0.13;
  /// The measurement's scale may be wrong by this share.
  double max_scale_error = 0.02;
  /// Marks that have to be found, as a share of the smaller of both lists.
  double min_share = 0.8;
};

/// By measured mark: the number of the mark, -1 for one that is none (dust). Each mark
/// occurs once. Errors: kMissing (fewer than 20 measured), kTooLarge (more than four
/// times the marks, or 20000), kInvalidValue (no turn and shift has enough marks
/// together: it gives how many the best has).
Result<std::vector<int>> MatchMarks(const std::vector<Vec2>& marks_mm,
                                    const std::vector<Vec2>& measured_mm,
                                    const MatchOptions& options = {});

}  // namespace intaglio::calibrate
