#pragma once

// The stage position that brings the focus to a point of the block: glass frame (origin
// at the block's corner, z up, the beam comes from +z) to machine frame, mm.
//
// Across the beam the stage moves as the focus does. Along it the beam refracts at the
// top face: for the focus to be at depth d = block z - z below the face, the stage moves
// d * stage_per_glass_ratio, less than d (about d / n), from the position with the focus
// on the face itself (the inverse of Trochimczuk 2008 ch. 5). The machine's z is
// therefore the position that the focus would have in air.

#include "engrave/core/geometry.h"

namespace intaglio::optics {

struct MachineFromGlass {
  Vec3 block_origin_mm = Vec3::Zero();  ///< the block's corner in the machine frame
  Vec3 block_size_mm = Vec3::Zero();    ///< of which z, the top face, matters
  /// Stage move for a focus move in the glass, 0 < ratio <= 1; 1 is air.
  double stage_per_glass_ratio = 1;

  Vec3 ToMachine(const Vec3& glass_mm) const {
    const double depth_mm = block_size_mm.z() - glass_mm.z();
    return {block_origin_mm.x() + glass_mm.x(), block_origin_mm.y() + glass_mm.y(),
            top_z_mm() - depth_mm * stage_per_glass_ratio};
  }

  Vec3 ToGlass(const Vec3& machine_mm) const {
    const double depth_mm = (top_z_mm() - machine_mm.z()) / stage_per_glass_ratio;
    return {machine_mm.x() - block_origin_mm.x(), machine_mm.y() - block_origin_mm.y(),
            block_size_mm.z() - depth_mm};
  }

  double top_z_mm() const { return block_origin_mm.z() + block_size_mm.z(); }
};

}  // namespace intaglio::optics
