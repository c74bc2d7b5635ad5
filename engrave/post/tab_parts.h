#pragma once

// Paths with tabs: how a tool that keeps its depth along a path leaves them standing. The
// controllers' templates have lines and arcs in the plane alone, so a path is divided
// where a tab begins and ends; each part has its own approach, depth and retract.

#include <vector>

#include "engrave/post/cutting.h"
#include "engrave/post/tool_path.h"

namespace intaglio::post {

struct PathPart {
  ToolPath path;
  double depth_mm = 0;  ///< z of the tool
};

bool HasTabs(const ToolPath& path);

/// What pass `pass` (of cutting.depths_mm, from 0) makes of a path, in its order. A path
/// without tabs, and a pass that is not deeper than their top, is one part. The first
/// deeper pass makes the tabs at their top; further ones leave them out, and so do all
/// passes where tabs have no top.
std::vector<PathPart> PartsOfPass(const ToolPath& path, const Cutting& cutting,
                                  std::size_t pass);

}  // namespace intaglio::post
