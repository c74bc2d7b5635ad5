#pragma once

// Images as strokes of a beam: rows, or a halftone of dots.

#include <optional>

#include "engrave/core/result.h"
#include "services/job/marks/mark_shapes.h"

namespace intaglio {

/// Rows from below to above, each next one coming back; a stroke from edge to edge of the
/// pixels that are darker than the threshold, as shown. Dots by error diffusion of linear
/// light on a square grid, each a stroke along x whose middle is its place; with `rows`
/// the strokes of a row are one dashed shape. The picture gets as many pixels as its
/// scale or fit needs, so that the distance stays. `item` with its defaults. Errors begin
/// with the field.
Result<MarkShapes> ImageShapes(const MarkItem& item, const MarkFile& file,
                               const ReadLimits& limits,
                               const std::optional<DotRows>& rows);

}  // namespace intaglio
