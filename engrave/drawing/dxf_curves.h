#pragma once

#include "engrave/drawing/dxf_groups.h"

namespace intaglio::drawing {

/// What an entity of geometry is, in world coordinates and units of the file.
struct DxfCurve {
  DxfCommon common;
  Curve curve;  ///< without pieces: nothing to engrave (a mesh)
};

/// Whether DxfCurveOf knows the type: LINE, POINT, CIRCLE, ARC, ELLIPSE, LWPOLYLINE,
/// POLYLINE, SPLINE.
bool IsDxfCurve(std::string_view type);

/// The curve of an entity. False: the builder has the error.
bool DxfCurveOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result);

/// The cubic spline of two continuous derivatives through the points, with the chords as
/// parameter; ends as the tangents say, which may be zero: then free of bend. Closed when
/// first and last point are the same: then periodic. At least two points, no two
/// neighbours the same (de Boor 1978, ch. IV).
std::vector<Piece> SplineThrough(const PointList& points, const Vec3& begin_tangent,
                                 const Vec3& end_tangent);

/// From p to q with bulge = tan(sweep / 4), positive to the left; a line when the bulge
/// is too small to be seen.
Piece BulgedSegment(const Vec3& p, const Vec3& q, double bulge);

}  // namespace intaglio::drawing
