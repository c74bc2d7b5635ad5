#pragma once

// The way of an item's shapes to their place on the piece: scale, rotate, fit, centre,
// move.

#include <Eigen/Geometry>
#include <vector>

#include "proto/mark.pb.h"
#include "services/job/marks/mark_shapes.h"

namespace intaglio {

/// place = linear * shape + offset.
struct ItemPlace {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Vec2 offset_mm = Vec2::Zero();
  double scale = 1;      ///< of lengths
  double angle_rad = 0;  ///< counterclockwise

  Vec2 operator()(const Vec2& p) const { return linear * p + offset_mm; }
};

std::vector<Vec2> CornersOf(const Box3& box_mm);

/// By scale_ratio and the fit of what these points span.
double ScaleOfItem(const MarkPlacement& placement, const std::vector<Vec2>& points_mm);

/// `placement` with its defaults.
ItemPlace PlaceOf(const MarkPlacement& placement, const MarkShapes& shapes);

}  // namespace intaglio
