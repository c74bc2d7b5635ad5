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
  /// An oblique beam has it: depth between the meetings of the rays beside its plane of
  /// incidence and of those in it.
  double apart_mm = 0;
};

/// `stage_mm`, machine frame: its z is where the marginal rays would meet in air.
/// `slopes`: how far the axis of the beam goes aside for 1 mm down.
Focus TraceFocus(const Vec3& stage_mm, const BlockInMachine& block,
                 const Vec2& slopes = Vec2::Zero());

/// The peak intensity that a beam keeps whose foci are so far apart, 0..1. A sum of plane
/// waves has it within 0.06 for apertures of 0.03 to 0.05.
double PeakLeft(const BlockInMachine& block, double apart_mm, double wavelength_mm);

}  // namespace intaglio::virtual_engraver
