#pragma once

// A picture of marks that lie beside their places: an arrow from each place, many times
// longer than the deviation, the longest in red. Seen from above, x to the right, y up.
// One or more panels side by side, each with a scale of its own and a bar that shows it.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

struct Deviation {
  Vec2 place_mm = Vec2::Zero();
  Vec2 by_mm = Vec2::Zero();
};

struct DeviationPanel {
  std::string title;
  std::vector<Deviation> deviations;
};

/// How much longer the arrows are than the deviations: a round number (1, 2 or 5 times a
/// power of ten), so that the root of their mean square is a thirtieth of the marks'
/// extent or less. 1 without deviations.
double MagnificationOf(const std::vector<Deviation>& deviations);

/// `figures`: lines below the panels; what follows two blanks stands in a column.
Canvas DrawDeviations(const std::vector<DeviationPanel>& panels,
                      const std::vector<std::string>& figures);

}  // namespace intaglio::render
