#pragma once

// The marks of a calibration grid as somebody measured them, with what was commanded.

#include <optional>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/galvo/head_fit.h"
#include "services/client/machine/measured_marks.h"

namespace intaglio::cli {

struct GridMarksOptions {
  client::MarksFile measured;
  /// Nodes of the grid, when its commands are not in the file; 0: they are.
  int nodes = 0;
  std::optional<double> pitch_mm;
};

/// With `nodes` places or a picture, in which each mark is matched to a node; prints how
/// many were found. Errors name the file, or the option that is missing.
Result<std::vector<galvo::GridMark>> ReadGridMarks(const GridMarksOptions& options);

}  // namespace intaglio::cli
