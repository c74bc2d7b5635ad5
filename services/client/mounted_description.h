#pragma once

#include <optional>

#include "engrave/core/geometry.h"
#include "engrave/optics/focus.h"

namespace intaglio::client {

/// What the synchronizer knows of the parts mounted in the machine; empty: not known.
struct MountedDescription {
  std::optional<Vec3> block_size_mm;
  std::optional<double> refractive_index;  ///< at the laser's wavelength
  std::optional<optics::Lens> lens;
};

}  // namespace intaglio::client
