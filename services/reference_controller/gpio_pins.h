#pragma once

// The lines of a Linux board's GPIO chips, by libgpiod. Inputs are pulled to where they
// read off while their cable is off, by chips that can. A line that another program has
// is an error.

#include <memory>

#include "proto/laser_board.pb.h"
#include "services/reference_controller/laser_pins.h"

namespace intaglio::reference_controller {

/// Outputs are requested first, each off. `board` is checked. kIo names the line and its
/// signal.
Result<std::unique_ptr<LaserPins>> OpenGpioPins(const LaserBoard& board);

}  // namespace intaglio::reference_controller
