#pragma once

// The blocks on the table. Further ones are as large as the first and of the same glass;
// each has a frame of its own, whose corner and turn are those of the block.

#include <cstdint>
#include <span>

#include "services/virtual_engraver/beam.h"

namespace intaglio::virtual_engraver {

/// Where a further block lies: as the first, moved, and then turned about the vertical at
/// the origin of the machine frame, counterclockwise seen from above.
struct StationInMachine {
  Vec3 offset_mm = Vec3::Zero();
  double turn_rad = 0;
};

struct StationFocus {
  std::uint8_t station = 1;  ///< 1: the first block
  Focus focus;               ///< in the frame of this block
};

/// In the block that the beam meets; beside all blocks, relative to the nearest one.
/// `stage_mm` and `slopes` as of TraceFocus.
StationFocus TraceFocus(const Vec3& stage_mm, const BlockInMachine& block,
                        std::span<const StationInMachine> further,
                        const Vec2& slopes = Vec2::Zero());

}  // namespace intaglio::virtual_engraver
