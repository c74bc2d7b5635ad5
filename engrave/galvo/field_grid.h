#pragma once

// Vectors at the nodes of a square grid over the field, e.g. measured deviations.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::galvo {

struct FieldGrid {
  int nodes = 0;        ///< a side, 2..1025
  double first_mm = 0;  ///< x and y of the first node
  double pitch_mm = 0;  ///< > 0
  /// nodes x nodes, row by row: node (i, j) at x = first + i pitch, y = first + j pitch
  /// has the index j nodes + i.
  std::vector<Vec2> values_mm;

  Vec2 PlaceOf(int i, int j) const {
    return Vec2(first_mm + i * pitch_mm, first_mm + j * pitch_mm);
  }
  std::size_t IndexOf(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nodes) +
           static_cast<std::size_t>(i);
  }
};

/// A grid of zeros over a field of this width around the origin.
FieldGrid CentredGrid(double width_mm, int nodes);

/// kInvalidValue: nodes, pitch, or a value that is no number, with the node.
Status CheckGrid(const FieldGrid& grid);

}  // namespace intaglio::galvo
