#pragma once

// Reads HPGL, the pen plotters' language.
//
// What is read: IN DF PU PD PA PR (pen and moves), AA AR (arcs), CI (circle), EA ER RA RR
// (rectangles), EW WG (wedges), SP (pen: the layer). Rectangles and wedges that are
// filled become their outline. Texts (LB), device control (ESC), and all other
// instructions are passed over and counted. A scale of the user's own (SC with numbers)
// is an error. Frame: the plotter's, y up. Units: 40 a millimetre.

#include <string_view>

#include "engrave/core/result.h"
#include "engrave/drawing/read_options.h"

namespace intaglio::drawing {

/// options.unit_mm: mm that a plotter unit is long, 0.025 by default. Errors name file,
/// byte, instruction and remedy: kUnreadable (no instructions), kInvalidValue (numbers),
/// kUnsupported (SC), kTooLarge (a limit).
Result<Drawing> ReadHpgl(std::string_view text, const ReadOptions& options = {},
                         std::string_view name = "drawing");

}  // namespace intaglio::drawing
