#include "engrave/discretize/picture/halftone_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"

namespace intaglio::discretize {
namespace {

constexpr double kLargest_mm = 1000;

Status CheckSide(const char* name, double side_mm) {
  if (side_mm >= 0 && side_mm <= kLargest_mm) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} must be 0..{:g} mm, is {:g}", name, kLargest_mm, side_mm),
              fmt::format("{:g}", side_mm));
}

}  // namespace

Result<Vec2> PanelSizeOf(const image::GreyImage& picture, const PanelSize& size,
                         double vertex_distance_mm) {
  INTAGLIO_TRY(CheckSide("width_mm", size.width_mm));
  INTAGLIO_TRY(CheckSide("height_mm", size.height_mm));
  const Vec2 pixels(picture.width, picture.height);
  if (size.rule == PanelSize::Rule::kPixel) return Vec2(pixels * vertex_distance_mm);
  const Vec2 scale(size.width_mm / pixels.x(),
                   size.height_mm / pixels.y());  // mm a pixel
  if (!(scale.maxCoeff() > 0)) {
    return Fail(ErrorCode::kMissing,
                "a picture needs its width_mm or its height_mm: give one of them");
  }
  if (scale.minCoeff() == 0) return Vec2(pixels * scale.maxCoeff());
  if (size.rule == PanelSize::Rule::kFit) return Vec2(pixels * scale.minCoeff());
  return Vec2(size.width_mm, size.height_mm);
}

PointList PanelCorners(const Vec2& size_mm, double thickness_mm) {
  PointList corners;
  for (const double z : {0.0, thickness_mm}) {
    for (const double y : {0.0, size_mm.y()}) {
      for (const double x : {0.0, size_mm.x()}) corners.emplace_back(x, y, z);
    }
  }
  return corners;
}

Result<Panel> PlacePanel(const Vec2& size_mm, const mesh::GlassFromModel& placement) {
  const Vec3 x = placement.linear.col(0), y = placement.linear.col(1),
             z = placement.linear.col(2);
  const double longest = std::max({x.norm(), y.norm(), z.norm()});
  const double shear =
      std::max({std::abs(x.dot(y)), std::abs(y.dot(z)), std::abs(z.dot(x))});
  if (!(std::min({x.norm(), y.norm(), z.norm()}) > 0) ||
      shear > 1e-9 * longest * longest || !placement.offset_mm.allFinite()) {
    return Fail(ErrorCode::kInvalidValue,
                "a picture can be rotated, mirrored, scaled and moved, but not sheared "
                "or flattened: correct its placement");
  }
  Panel panel;
  panel.origin_mm = placement.offset_mm;
  panel.right = x.normalized();
  panel.up = y.normalized();
  panel.normal = z.normalized();
  panel.width_mm = size_mm.x() * x.norm();
  panel.height_mm = size_mm.y() * y.norm();
  panel.depth_ratio = z.norm();
  return panel;
}

Status CheckLayerPlaces(double count) {
  if (count <= kMaxLayerPlaces) return {};
  return Fail(
      ErrorCode::kTooLarge,
      fmt::format(
          "a layer of the picture would have {:.0f} candidates, more than the {:.0f} "
          "allowed: increase vertex_distance_mm, or make the picture smaller",
          count, kMaxLayerPlaces),
      fmt::format("{:.0f}", count));
}

}  // namespace intaglio::discretize
