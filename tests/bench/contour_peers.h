#pragma once

// Unions of the same elements by other libraries, where they are installed.

#include <optional>
#include <span>

#include "engrave/contour/element.h"

namespace intaglio::bench {

struct PeerUnion {
  double seconds = 0;
  double area_mm2 = 0;
  std::size_t contours = 0;
};

/// CGAL's polygon set of lines and arcs, in exact arithmetic. A track's normal is a
/// rational vector of length 1, 1e-16 off. Nothing where CGAL is not installed.
std::optional<PeerUnion> UniteByCgal(std::span<const contour::Element> elements,
                                     double tool_radius_mm);

/// Processor time of this thread, s.
double ProcessorSeconds();

}  // namespace intaglio::bench
