#include "engrave/discretize/drawing/place_drawing.h"

#include <Eigen/Geometry>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::discretize {

Result<PlacedDrawing> PlaceDrawing(const drawing::Drawing& drawing,
                                   const mesh::Placement& placement,
                                   const Vec3& block_size_mm,
                                   const drawing::FlattenOptions& flatten,
                                   double join_mm) {
  // Fit and centre need the extent, which the flattened curves give within the tolerance.
  const auto unplaced = INTAGLIO_TRY(drawing::Flatten(drawing, flatten));
  PointList points;
  for (const drawing::FlatCurve& curve : unplaced.curves) {
    points.insert(points.end(), curve.points_mm.begin(), curve.points_mm.end());
  }
  if (points.empty()) {
    return Fail(ErrorCode::kMissing,
                "the drawing has no curves; convert its texts to paths");
  }
  const auto glass =
      INTAGLIO_TRY(mesh::GlassFromModelOf(points, placement, block_size_mm));
  drawing::Drawing moved = drawing;
  drawing::Transform(glass.linear, glass.offset_mm, moved);
  auto flat = INTAGLIO_TRY(drawing::Flatten(moved, flatten));
  if (join_mm > 0) drawing::JoinOpenCurves(join_mm, flat);
  // Two flattened images of one curve are apart by their two tolerances.
  drawing::RemoveRepeatedContours(join_mm + 2 * flatten.chord_tolerance_mm, flat);
  const Vec3 normal = glass.linear.col(0).cross(glass.linear.col(1)).normalized();
  return PlacedDrawing{std::move(flat), normal};
}

}  // namespace intaglio::discretize
