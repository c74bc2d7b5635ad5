#pragma once

#include <optional>

#include "engrave/core/check.h"
#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

struct ReadOptions {
  DrawingLimits limits;
  /// mm that a unit of the file is long; positive. Default: what the file declares, or
  /// what its format says.
  std::optional<double> unit_mm;
};

/// Throws PreconditionError.
inline void RequireUsable(const ReadOptions& options) {
  Require(!options.unit_mm || *options.unit_mm > 0, "unit_mm must be positive, is {}",
          options.unit_mm.value_or(0));
}

}  // namespace intaglio::drawing
