#pragma once

// Arcs as a controller reads them from a program: a program has rounded numbers, and an
// arc whose rounded ends agree is a whole turn to a controller. So is one whose rounded
// end lies before its rounded begin. Frame: drawing, mm.

#include "engrave/post/template.h"
#include "engrave/post/tool_path.h"

namespace intaglio::post {

/// The variables of an arc that a template writes.
struct ArcVariables {
  bool place = false;   ///< X Y
  bool center = false;  ///< I J, from the begin
  bool middle = false;  ///< AX AY
  bool angle = false;   ///< P: the sweep is written, and no place decides it
};

/// The path with those arcs only that the numbers of the program determine. What bends
/// less than half of the last decimal becomes a line, or nothing where its ends agree as
/// they are written; another arc whose numbers determine a different sweep, or whose
/// radius is below 2 um, is divided until they do not. No place of the result is farther
/// than the last decimal from the path. `origin_mm`: of the program.
ToolPath WritablePath(const ToolPath& path, const Template& program,
                      const ArcVariables& variables, const Vec2& origin_mm);

}  // namespace intaglio::post
