#pragma once

#include <limits>

#include "engrave/discretize/picture/halftone_screen.h"

namespace intaglio::discretize {

struct SettleOptions {
  int round_count = 6;
  double spacing_mm = 0.1;  ///< no two points come nearer; the screen keeps it
  double reach_mm = std::numeric_limits<double>::infinity();  ///< from where they began
};

/// Moves the points of a screen of that grid and density towards the middle of the
/// brightness nearest to each, a part of the way where the spacing of a neighbour forbids
/// the whole. Their number stays, and so does the tone; where a layer is full nothing
/// moves. Deterministic; time grows with the places of the grid.
void Settle(const HalftoneGrid& grid, const DensityOf& density,
            const SettleOptions& options, PanelPoints& points);

}  // namespace intaglio::discretize
