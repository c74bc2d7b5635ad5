#pragma once

// Reads SVG 1.1 and 2.
//
// What is read: path with every command, rect with round corners, circle, ellipse, line,
// polyline, polygon; svg, g, a, switch and symbol with transforms and viewBox; use with
// its references. The outline of every shape is a curve, filled or not. Elements with
// display: none or visibility: hidden, and those whose transform leaves no area of them,
// are skipped and counted, as are texts, images and all other elements. Display,
// visibility and stroke are read from attributes, style attributes and style sheets with
// selectors of elements, classes and ids. Frame: y is flipped, so that the page's
// lower left corner is the origin. Units: the page's width and height with viewBox; a
// bare number and px are 1/96 inch. layer: label or id of the group; color: the stroke.

#include <string_view>

#include "engrave/core/result.h"
#include "engrave/drawing/read_options.h"

namespace intaglio::drawing {

/// options.unit_mm: mm that a user unit (px) of the page is long. Errors name file, line,
/// element and remedy: kUnreadable (no XML, no svg), kInvalidValue (a number, path or
/// transform), kTooLarge (a limit, references that hold themselves).
Result<Drawing> ReadSvg(std::string_view text, const ReadOptions& options = {},
                        std::string_view name = "drawing");

}  // namespace intaglio::drawing
