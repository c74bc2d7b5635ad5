#pragma once

// The outputs of a BJJCZ board, for the drivers of points and of marks alike. One rule
// for both lasers: the guide laser is on while a person holds an outline and at no other
// time, and the gate of the laser is closed as long as an outline is drawn, whatever else
// wants it open.

#include <cstdint>

#include "proto/machine.pb.h"

namespace intaglio::drivers {

struct BoardOutputs {
  bool permitted = false;   ///< the laser may be on
  bool runs = false;        ///< points or marks are made
  bool in_outline = false;  ///< one was begun, and the mirrors do not rest yet
  bool shows = false;       ///< it is held, and the mirrors are on its way
};

/// As the board's command for its outputs has them. An output that the profile does not
/// name stays off.
std::uint16_t OutputBits(const BjjczBoard& board, const BoardOutputs& outputs);

}  // namespace intaglio::drivers
