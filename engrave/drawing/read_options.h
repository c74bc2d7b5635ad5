#pragma once

#include <optional>

#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

struct ReadOptions {
  DrawingLimits limits;
  /// mm that a unit of the file is long; positive. Default: what the file declares, or
  /// what its format says.
  std::optional<double> unit_mm;
};

}  // namespace intaglio::drawing
