#pragma once

// A picture of parts on sheets: all sheets side by side in rows, each with its parts, the
// margin along its border dashed, and its number, parts and use below.

#include <vector>

#include "engrave/contour/region/region.h"
#include "engrave/render/canvas.h"

namespace intaglio::cli {

struct SheetDrawing {
  std::vector<contour::Region> parts;  ///< at their places; sheet frame, mm
};

/// At least one sheet; more than 100 are drawn as the first 100, and a line says so.
render::Canvas DrawSheets(const std::vector<SheetDrawing>& sheets, const Vec2& sheet_mm,
                          double margin_mm);

}  // namespace intaglio::cli
