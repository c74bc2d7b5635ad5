#pragma once

// Reads HPGL, the pen plotters' language.
//
// What is read: IN DF PU PD PA PR (pen and moves), AA AR (arcs), CI (circle), EA ER RA RR
// (rectangles), EW WG (wedges), SP (pen: the layer). Filled rectangles and wedges become
// their outline. Texts (LB), device control (ESC), and all other instructions are skipped
// and counted. Frame: the plotter's, y up. Units: 40 per millimetre, or those of a scale
// (SC of every kind) between scaling points (IP). The plotter's page is not known: a
// scale that needs it (kinds 0 and 1 without IP, any with IR) is an error, and P1 is the
// origin by default.

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
