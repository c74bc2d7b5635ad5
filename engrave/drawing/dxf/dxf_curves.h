#pragma once

#include "engrave/drawing/dxf/dxf_groups.h"

namespace intaglio::drawing {

/// The geometry of an entity, in world coordinates and units of the file.
struct DxfCurve {
  DxfCommon common;
  Curve curve;             ///< without pieces: nothing to engrave (a mesh)
  std::string_view wrong;  ///< why there are none, behind its type: "without a radius"
};

/// Whether DxfCurveOf supports the type: LINE, POINT, CIRCLE, ARC, ELLIPSE, LWPOLYLINE,
/// POLYLINE, SPLINE.
bool IsDxfCurve(std::string_view type);

/// The curve of an entity. False: the builder has the error.
bool DxfCurveOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result);

struct DxfVertex {
  Vec3 p = Vec3::Zero();
  double bulge = 0;  ///< of the segment to the next vertex
};

/// Adds the pieces through the vertices. False: too many points.
bool DxfPolyline(const std::vector<DxfVertex>& vertices, bool closed,
                 const DxfEntity& entity, DrawingBuilder& builder,
                 std::vector<Piece>& pieces);

/// Counter-clockwise from begin to end, in (0, 2 pi].
double DxfSweep(double begin_rad, double end_rad);

/// From p to q with bulge = tan(sweep / 4), positive to the left; a line when the bulge
/// is too small to be seen.
Piece BulgedSegment(const Vec3& p, const Vec3& q, double bulge);

}  // namespace intaglio::drawing
