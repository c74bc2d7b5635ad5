#pragma once

#include <optional>

#include "engrave/core/check.h"
#include "engrave/drawing/drawing.h"
#include "engrave/drawing/font_source.h"

namespace intaglio::drawing {

struct ReadOptions {
  DrawingLimits limits;
  /// Length of the file's unit, mm; positive. Default: as the file declares, or as its
  /// format defines.
  std::optional<double> unit_mm;
  /// Of the texts in a DXF. Default: texts are left out.
  std::optional<FontSource> text_font;
};

/// Throws PreconditionError.
inline void RequireUsable(const ReadOptions& options) {
  Require(!options.unit_mm || *options.unit_mm > 0, "unit_mm must be positive, is {}",
          options.unit_mm.value_or(0));
}

}  // namespace intaglio::drawing
