#pragma once

// Marks as they look on the material: every place nearer to one than half a line's width
// is dark.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/mark/mark.h"

namespace intaglio::mark {

struct BurntPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  ///< 0 dark, 255 bright; row 0 on top
};

/// `low_mm`..`high_mm` of the piece, `pixel_mm` a pixel.
BurntPicture Burn(const std::vector<Mark>& marks, double line_mm, const Vec2& low_mm,
                  const Vec2& high_mm, double pixel_mm);

}  // namespace intaglio::mark
