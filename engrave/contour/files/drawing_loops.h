#pragma once

// The curves of a drawing (DXF, SVG, HPGL, NCI; engrave/drawing) as closed loops of lines
// and arcs, for cuts, pockets and outlines. Frame: drawing, mm; z is left out.
//
// Circles and arcs of circles stay arcs, exactly; splines and ellipses become chords.
// Open curves that meet are one loop: CAD programs write an outline as single lines and
// arcs. What is only followed may stay open.

#include <vector>

#include "engrave/contour/region/region.h"
#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"

namespace intaglio::contour {

struct LoopOptions {
  double chord_tolerance_mm = 0.005;  ///< of splines and ellipses, 1e-6 .. 1
  double joint_mm = 0.01;             ///< ends nearer than this are joined, 1e-5 .. 1
};

/// Loops that coincide with another one are left out. Errors: kInvalidValue for an option
/// outside its range, a contour that is open (with its place: an open contour would be
/// cut wrongly or not at all), or a drawing without a curve; kTooLarge as of Flatten.
Result<std::vector<Edges>> LoopsOfDrawing(const drawing::Drawing& drawing,
                                          const LoopOptions& options = {});

/// A curve that is followed as it is.
struct FollowedCurve {
  Edges edges;  ///< each begins where the one before ends
  bool closed = false;
};

/// Open curves as well. Those of the same layer are joined where exactly two of their
/// ends meet, by a line where there is a gap; closed ones that coincide with another one
/// are left out. In the order of their first parts; points of the drawing are left out.
/// Errors: kInvalidValue for an option outside its range; kTooLarge as of Flatten.
Result<std::vector<FollowedCurve>> CurvesOfDrawing(const drawing::Drawing& drawing,
                                                   const LoopOptions& options = {});

}  // namespace intaglio::contour
