#include "services/virtual_engraver/bodies.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace intaglio::virtual_engraver {
namespace {

// A touch is none; the stage's own errors are a hundredth of it.
constexpr double kRecordedMm = 0.1;

/// How deep a cylinder whose axis goes through `axis_mm`, from `bottom_mm` up, is in a
/// box; not above 0: it is free. The nearest place of the box to the axis decides, seen
/// from above.
double DepthIn(const Box3& box, const Vec3& axis_mm, double bottom_mm, double radius_mm) {
  const double beside_x =
      std::max({box.min_mm.x() - axis_mm.x(), 0.0, axis_mm.x() - box.max_mm.x()});
  const double beside_y =
      std::max({box.min_mm.y() - axis_mm.y(), 0.0, axis_mm.y() - box.max_mm.y()});
  if (std::hypot(beside_x, beside_y) >= radius_mm) return 0;
  return box.max_mm.z() - bottom_mm;
}

}  // namespace

Bodies::Bodies(const BodyOptions& options, const BlockInMachine& block,
               std::span<const StationInMachine> further)
    : corner_mm_(block.origin_mm) {
  const Vec3& corner = block.origin_mm;
  solids_.push_back({0, {corner, corner + block.size_mm}, 0});
  for (const StationInMachine& station : further) {
    const Vec3 moved = corner + station.offset_mm;
    solids_.push_back({0, {moved, moved + block.size_mm}, station.turn_rad});
  }
  std::uint8_t number = 0;
  for (const Box3& obstacle : options.obstacles) {
    solids_.push_back(
        {++number, {corner + obstacle.min_mm, corner + obstacle.max_mm}, 0});
  }
  const std::array bodies = {options.lens, options.carrier};
  for (std::uint8_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i]) continue;
    hanging_.push_back({i, *bodies[i], std::vector<double>(solids_.size(), 0)});
  }
}

void Bodies::Move(const Vec3& focus_mm, std::uint64_t tick, const Sink& sink) {
  for (Hanging& hanging : hanging_) {
    const double bottom_mm = focus_mm.z() + hanging.body.above_focus_mm;
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const Solid& solid = solids_[i];
      const Vec3 axis_mm = Eigen::AngleAxisd(-solid.turn_rad, Vec3::UnitZ()) * focus_mm;
      const double depth_mm =
          DepthIn(solid.box, axis_mm, bottom_mm, hanging.body.radius_mm);
      double& recorded_mm = hanging.recorded_mm[i];
      if (depth_mm <= 0) {
        recorded_mm = 0;
      } else if (depth_mm >= recorded_mm + kRecordedMm) {
        recorded_mm = depth_mm;
        sink({tick, focus_mm - corner_mm_, depth_mm, hanging.number, solid.number});
      }
    }
  }
}

}  // namespace intaglio::virtual_engraver
