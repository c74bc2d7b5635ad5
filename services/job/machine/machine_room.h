#pragma once

// How much floor the moving parts of a positioner take (Trochimczuk 2008 ch. 9, table 7:
// "room for installation", in words there).

#include "engrave/core/geometry.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Sides in x and y of the machine frame, mm, of the rectangle about all that block,
/// beam, table and arm reach over the whole travel of the axes. Of an arm and a table
/// also the arm's axis, and the round table where `loading` has its radius. Motors and
/// housing are not known.
Vec2 RoomOf(const MachineSpec& machine, const Vec3& block_mm);

}  // namespace intaglio
