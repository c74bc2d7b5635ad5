#pragma once

// Tabs of a course on paths that follow contours as they are. Frame: that of the files.

#include <string>

#include "engrave/contour/edge.h"
#include "engrave/contour/milling/cut.h"
#include "engrave/core/result.h"
#include "engrave/post/tool_path.h"
#include "proto/course.pb.h"

namespace intaglio {

/// `course` with its defaults filled in.
contour::TabOptions TabsOf(const Course& course);

/// The path along edges, divided at the tabs that the course asks for; without tabs the
/// edges as they are. kUnsupported: an edge path that does not hold them (cut_tabs.h).
Result<post::ToolPath> PathWithTabs(const Course& course, const contour::Edges& edges,
                                    std::string name);

}  // namespace intaglio
