#pragma once

// A picture of contours as an SVG file, 1:1 in millimetres, with exact arcs: copper as an
// area, contours by pass, tabs, idle ways dashed, holes as rings. It can be read again as
// a drawing.

#include <string>
#include <vector>

#include "engrave/contour/region/region.h"
#include "services/job/course/course_work.h"

namespace intaglio::cli {

/// start_mm: where the tool comes from; tool_diameter_mm: how wide contours are drawn.
std::string SvgOf(const ContourWork& work, const Vec2& start_mm, double tool_diameter_mm);

/// Parts on a sheet: the picture is the sheet, and the parts alone are drawn, so that it
/// can be read as a drawing to cut.
std::string SvgOfSheet(const std::vector<contour::Region>& parts, const Vec2& sheet_mm);

}  // namespace intaglio::cli
