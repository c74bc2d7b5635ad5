#pragma once

// Which places of a grid get a point.

#include <cstdint>
#include <functional>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/discretize/picture/halftone_grid.h"
#include "engrave/discretize/picture/halftone_mask.h"

namespace intaglio::discretize {

/// Share of the places of a layer that get a point, 0..1, by the brightness there.
using DensityOf = std::function<double(float brightness)>;

/// Points on the panel, mm, within [0, width) x [0, height).
using PanelPoints = std::vector<Vec2>;

/// By the mask, shifted by `seed`. The grid is triangular.
PanelPoints ScreenByMask(const HalftoneGrid& grid, const DensityOf& density,
                         const HalftoneMask& mask, std::uint64_t seed);

/// By error diffusion. The grid is square.
PanelPoints ScreenByErrors(const HalftoneGrid& grid, const DensityOf& density,
                           std::uint64_t seed);

}  // namespace intaglio::discretize
