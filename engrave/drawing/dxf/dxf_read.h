#pragma once

// Reads DXF in text and in binary form, of every release.
//
// What is read: LINE, POINT, CIRCLE, ARC, ELLIPSE, LWPOLYLINE and POLYLINE with bulges,
// SPLINE by control points and weights or by fit points, the boundary of HATCH, INSERT of
// blocks with scale, rotation and arrays, blocks in blocks, clips of blocks (XCLIP),
// extrusion directions; with a font TEXT, MTEXT and ATTRIB, all in this font. All else
// (dimensions, patterns, meshes, sheets, entities that are invisible or on a layer that
// is off or frozen) is counted in the findings. Units: $INSUNITS; millimetres when the
// file names none.
//
// Own code, not dxflib 3.26: of seven damaged files of a hundred bytes, one crashed the
// process, the second took 16 GB and the third never returned.

#include <string_view>

#include "engrave/core/result.h"
#include "engrave/drawing/read_options.h"

namespace intaglio::drawing {

/// Errors name file, line, entity and remedy: kUnreadable (damaged, cut off),
/// kUnsupported (DWG, an unknown unit), kInvalidValue (a number, a spline, a
/// block that holds itself), kNotFound (a block), kTooLarge (a limit).
Result<Drawing> ReadDxf(std::string_view text, const ReadOptions& options = {},
                        std::string_view name = "drawing");

}  // namespace intaglio::drawing
