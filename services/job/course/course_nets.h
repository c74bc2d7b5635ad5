#pragma once

// Proves by geometry that what an isolation leaves of a board has the nets that were
// drawn. Frame: that of the files, mm.

#include <optional>
#include <string>
#include <vector>

#include "engrave/contour/isolation.h"
#include "engrave/contour/milling/nets.h"
#include "engrave/core/result.h"

namespace intaglio {

/// A board whose nets its file has.
struct DrawnNets {
  std::string file;
  std::vector<std::string> layers;  ///< front first; bit 1 << k each
  std::uint32_t layer = 0;          ///< the one that is made
  std::vector<contour::NetElement> elements;
};

/// The layer that is made is the copper that the isolation leaves, the others are as they
/// are drawn. kUnsupported: a net is short, open, or lost, each with its place.
Result<contour::NetReport> ProveNets(const DrawnNets& drawn,
                                     const contour::Isolation& isolation,
                                     double tool_diameter_mm);

}  // namespace intaglio
