#pragma once

#include <Eigen/Core>
#include <span>

#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

/// Point of the piece at t, 0..1 (NURBS: over its range of knots), mm. Not for a
/// polyline, which holds its points itself.
Vec3 PointAt(const EllipticArc& arc, double t);
Vec3 PointAt(const CubicBezier& bezier, double t);
/// At a knot value u within the range of knots.
Vec3 PointAtKnot(const Nurbs& nurbs, double u);
/// The blossom of the polynomial between knots[span] and knots[span + 1], in homogeneous
/// coordinates, of `degree` arguments: its point at u where all are u.
Eigen::Vector4d BlossomOf(const Nurbs& nurbs, std::size_t span,
                          std::span<const double> arguments);

Vec3 BeginOf(const Piece& piece);
Vec3 EndOf(const Piece& piece);

/// Points and control points that make the piece.
std::size_t PointCountOf(const Piece& piece);

/// p -> linear p + offset, exactly.
void Transform(const Mat3& linear, const Vec3& offset_mm, Piece& piece);
void Transform(const Mat3& linear, const Vec3& offset_mm, Drawing& drawing);

/// Whether every number is finite and no point that makes the piece is farther from the
/// origin than `max_coordinate_mm`.
bool WithinReach(const Piece& piece, double max_coordinate_mm);

}  // namespace intaglio::drawing
