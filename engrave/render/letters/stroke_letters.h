#pragma once

// A glyph is a list of strokes, separated by blanks. A stroke begins with its kind,
//   l  straight lines from point to point
//   s  a smooth curve: the quadratic B-spline of the points, with its ends on the first
//      and last
//   c  the same, closed
// and goes on with points: a digit for x and a letter for y, d the baseline, j the
// height of an x, m the height of a capital (9 units), a the depth of a tail.

namespace intaglio::render {

/// The glyph of a character without an accent; nullptr: the stroke font does not have it.
const char* StrokesOf(char32_t sign);

}  // namespace intaglio::render
