#pragma once

#include "engrave/drawing/dxf/dxf_groups.h"

namespace intaglio::drawing {

/// A spline as its groups come.
class DxfSpline {
 public:
  /// Takes a group in the codes of a SPLINE: degree 71, knots 40, weights 41, control
  /// points 10 20 30, fit points 11 21 31, tangents 12 .. 33. False: too many points.
  bool Consume(int code, double number, const DxfEntity& entity, DrawingBuilder& builder);

  /// Adds the curve by control points; by fit points when there are none. False: it is
  /// no spline, and the builder has the error.
  bool AddPieces(const DxfEntity& entity, DrawingBuilder& builder,
                 std::vector<Piece>& pieces);

 private:
  Nurbs nurbs_;
  PointList through_;
  Vec3 begin_tangent_ = Vec3::Zero();
  Vec3 end_tangent_ = Vec3::Zero();
  double degree_ = 3;
  std::uint64_t number_count_ = 0;
};

/// The cubic spline of two continuous derivatives through the points, with the chords as
/// parameter; the end directions are the tangents; with a zero tangent the curvature at
/// that end is zero (natural end). When the first and the last point are the same, the
/// spline is closed and periodic. At least two points, no two neighbours the same (de
/// Boor 1978, ch. IV).
std::vector<Piece> SplineThrough(const PointList& points, const Vec3& begin_tangent,
                                 const Vec3& end_tangent);

}  // namespace intaglio::drawing
