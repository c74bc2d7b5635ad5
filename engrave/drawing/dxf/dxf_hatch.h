#pragma once

#include "engrave/drawing/dxf/dxf_groups.h"

namespace intaglio::drawing {

/// The boundary of a HATCH.
struct DxfHatch {
  DxfCommon common;
  /// Its contours in world coordinates and units of the file. If its edges do not join,
  /// each edge becomes a curve of its own.
  std::vector<Curve> contours;
  bool has_lines = false;  ///< a pattern of lines, which is not among them
};

/// Reads boundary paths by vertices with bulges and by edges: lines, arcs, elliptic arcs,
/// splines (DXF reference, HATCH and "Boundary path data"). Frames of texts are no
/// contours. False: the builder has the error.
bool ReadDxfHatch(const DxfEntity& entity, DrawingBuilder& builder, DxfHatch& hatch);

}  // namespace intaglio::drawing
