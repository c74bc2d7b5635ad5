#pragma once

// Reads NCI, the intermediate tool paths of Mastercam: pairs of lines, the number of a
// code and its parameters. Codes and sources: nci_codes.h.
//
// What is read: feed moves along lines (1) and arcs of the XY plane (2 clockwise, 3
// counter-clockwise) are curves; rapid moves (0, or a feed of -2) are jumps; tool records
// (1000 to 1002) give the layer, "T" and the number of the tool. z is kept. Feed moves
// that change z alone are plunges and retracts, and draw nothing. Everything else is
// named once with its first line and its number. Frame: that of the tool path, y up.
// Units: the file declares none; a unit is 1 mm by default.

#include <string_view>

#include "engrave/core/result.h"
#include "engrave/drawing/read_options.h"

namespace intaglio::drawing {

/// options.unit_mm: mm of a unit, 25.4 for inches. Errors name file, line, code and
/// remedy: kUnreadable (no pairs of codes and parameters), kInvalidValue (numbers),
/// kUnsupported (arcs of other planes), kTooLarge (a limit).
Result<Drawing> ReadNci(std::string_view text, const ReadOptions& options = {},
                        std::string_view name = "drawing");

}  // namespace intaglio::drawing
