#pragma once

// What `intaglio course plan` plans: the contours of a drawing.

#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/course/path.h"

namespace intaglio::cli {

/// The curves of a drawing (.dxf, .svg, .hpgl, .plt, .nci) in its own frame, mm; open
/// curves that meet are joined. Arcs become chords that are within a micrometre of them.
/// What the file holds that is no curve is added to `warnings`.
Result<std::vector<course::Path>> ReadContours(const std::string& file, double feed_mm_s,
                                               double size_limits, Warnings& warnings);

}  // namespace intaglio::cli
