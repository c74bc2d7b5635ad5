#pragma once

// A course as a page for a browser: one HTML file, which loads nothing, with play, pause,
// stop, feed and the place in time; the copper that is left and what the tool has swept.

#include <string>

#include "services/cli/contour/contour_motion.h"

namespace intaglio::cli {

/// The page has three scripts: "data" is JSON (lengths in mm, times in s; edges are
/// [x, y, x, y], of arcs followed by centre, radius, begin and sweep in rad), "model"
/// finds the tool at a time and knows no document, "view" draws and has the controls. Of
/// planned speeds the way is kept every 5 ms or at 4000 places of a leg, and is linear
/// between those.
std::string PageOf(const ContourWork& work, const ContourMotion& motion,
                   double tool_diameter_mm, const std::string& title);

}  // namespace intaglio::cli
