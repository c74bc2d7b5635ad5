#pragma once

// The lines of a Linux board's GPIO chips, by libgpiod. Inputs are pulled to where they
// read off while their cable is off, by chips that can. A line that another program has
// is an error.

#include <memory>

#include "services/reference_controller/board_file.h"
#include "services/reference_controller/pins.h"

namespace intaglio::reference_controller {

/// Outputs are requested first, each off. `lines`: those of a checked board
/// (BoardLines). kIo names the line and its signal.
Result<std::unique_ptr<Pins>> OpenGpioPins(const std::vector<NamedLine>& lines);

}  // namespace intaglio::reference_controller
