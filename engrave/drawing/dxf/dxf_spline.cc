#include "engrave/drawing/dxf/dxf_spline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engrave/core/counted.h"

namespace intaglio::drawing {
namespace {

bool CheckNurbs(const DxfEntity& entity, DrawingBuilder& builder, const Nurbs& nurbs,
                double degree) {
  if (!(degree >= 1 && degree <= kMaxSplineDegree) || degree != std::floor(degree)) {
    return Refuse(entity, builder, "the degree of a spline must be 1 to 15", degree);
  }
  const std::size_t controls = nurbs.control_mm.size();
  const std::size_t wanted = controls + static_cast<std::size_t>(degree) + 1;
  if (controls < static_cast<std::size_t>(degree) + 1 || nurbs.knots.size() != wanted) {
    return Refuse(
        entity, builder,
        fmt::format("{} of degree {} and {} do not make a spline "
                    "(one more knot than both together is needed, and more control "
                    "points than the degree); export the drawing again",
                    Counted(controls, "control point"), degree,
                    Counted(nurbs.knots.size(), "knot")),
        static_cast<double>(nurbs.knots.size()));
  }
  const auto falls = std::ranges::adjacent_find(nurbs.knots, std::greater<>());
  if (falls != nurbs.knots.end()) {
    return Refuse(entity, builder, "the knots of a spline must ascend", *falls);
  }
  if (!(nurbs.knots[static_cast<std::size_t>(degree)] < nurbs.knots[controls])) {
    return Refuse(entity, builder, "the knots of the spline span nothing",
                  nurbs.knots[controls]);
  }
  if (!nurbs.weights.empty() && nurbs.weights.size() != controls) {
    return Refuse(entity, builder, "a spline needs as many weights as control points",
                  static_cast<double>(nurbs.weights.size()));
  }
  for (const double weight : nurbs.weights) {
    if (!(weight > 1e-9 && weight < 1e9)) {
      return Refuse(entity, builder, "a weight of a spline must be 1e-9 to 1e9", weight);
    }
  }
  return true;
}

}  // namespace

bool DxfSpline::Consume(int code, double number, const DxfEntity& entity,
                        DrawingBuilder& builder) {
  // About five numbers per point: three coordinates, a knot and a weight.
  if (++number_count_ / 5 > builder.limits().max_points) {
    return builder.CountPoints(number_count_, entity.Place());
  }
  PointList& points = code % 10 == 0 ? nurbs_.control_mm : through_;
  const int axis = code / 10 - 1;
  if (code == 10 || code == 11) {
    points.emplace_back(number, 0, 0);
  } else if (code == 20 || code == 21 || code == 30 || code == 31) {
    if (!points.empty()) points.back()[axis] = number;
  } else if (code % 10 == 2 && code < 40) {
    begin_tangent_[axis] = number;
  } else if (code % 10 == 3 && code < 40) {
    end_tangent_[axis] = number;
  } else if (code == 40) {
    nurbs_.knots.push_back(number);
  } else if (code == 41) {
    nurbs_.weights.push_back(number);
  } else if (code == 71) {
    degree_ = number;
  }
  return true;
}

bool DxfSpline::AddPieces(const DxfEntity& entity, DrawingBuilder& builder,
                          std::vector<Piece>& pieces) {
  if (!nurbs_.control_mm.empty()) {
    if (!CheckNurbs(entity, builder, nurbs_, degree_)) return false;
    nurbs_.degree = static_cast<int>(degree_);
    pieces.push_back(std::move(nurbs_));
    return true;
  }
  // Not std::ranges::unique: clang 14, which builds the fuzz targets, cannot.
  const auto same = [](const Vec3& p, const Vec3& q) { return (p - q).norm() <= 1e-12; };
  through_.erase(std::unique(through_.begin(), through_.end(), same), through_.end());
  if (through_.size() < 2) {
    return Refuse(entity, builder, "a spline needs control points or two fit points",
                  static_cast<double>(through_.size()));
  }
  std::vector<Piece> curve = SplineThrough(through_, begin_tangent_, end_tangent_);
  std::ranges::move(curve, std::back_inserter(pieces));
  return true;
}

}  // namespace intaglio::drawing
