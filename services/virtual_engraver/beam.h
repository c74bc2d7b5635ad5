#pragma once

// Where the beam really meets: the machine's own optics, by tracing marginal rays through
// the top face of the block. Written for itself: it shares nothing with engrave/optics,
// so that a wrong sign or formula there shows as cracks at the wrong depth.

#include "engrave/core/geometry.h"

namespace intaglio::virtual_engraver {

/// A block under the lens. Machine frame, mm; the beam comes from +z.
struct BlockInMachine {
  Vec3 origin_mm = Vec3::Zero();  ///< the block's corner (0, 0, 0)
  Vec3 size_mm = Vec3::Constant(100);
  double refractive_index = 1.5;    ///< at the laser's wavelength, 1..4
  double numerical_aperture = 0.1;  ///< of the converging beam in air, 0..0.9
};

struct Focus {
  Vec3 position_mm = Vec3::Zero();  ///< glass frame
  bool in_glass = false;            ///< within the block
};

/// `stage_mm`, machine frame: its z is where the marginal rays would meet in air.
Focus TraceFocus(const Vec3& stage_mm, const BlockInMachine& block);

}  // namespace intaglio::virtual_engraver
