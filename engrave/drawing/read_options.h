#pragma once

#include <optional>

#include "engrave/core/check.h"
#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

struct ReadOptions {
  DrawingLimits limits;
  /// Length of the file's unit, mm; positive. Default: as the file declares, or as its
  /// format defines.
  std::optional<double> unit_mm;
};

/// Throws PreconditionError.
inline void RequireUsable(const ReadOptions& options) {
  Require(!options.unit_mm || *options.unit_mm > 0, "unit_mm must be positive, is {}",
          options.unit_mm.value_or(0));
}

}  // namespace intaglio::drawing
