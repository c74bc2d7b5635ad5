#pragma once

// The lattice of solids (solid.h): horizontal layers of rows, by the distance of nearest
// points. Its rows lie along x, and as well 60 and 120 degrees counterclockwise from it.

#include <array>
#include <cmath>

namespace intaglio::discretize {

/// From a row to the next one of its layer, by the distance.
inline double SolidRowRatio() { return std::sqrt(0.75); }

/// From a layer to the next one at a height ratio of 1, by the distance.
inline double SolidLayerRatio() { return std::sqrt(2.0 / 3); }

inline constexpr std::array kSolidRowTurnsDeg = {0.0, 60.0, 120.0};

}  // namespace intaglio::discretize
