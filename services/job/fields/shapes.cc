#include "services/job/fields/shapes.h"

#include <numbers>

#include "engrave/core/check.h"

namespace intaglio {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;

mesh::Fit FitOf(const Placement& placement, const Block& block) {
  switch (placement.fit_case()) {
    case Placement::kFitHeightMm:
      return mesh::FitHeight{placement.fit_height_mm()};
    case Placement::kFitSizeMm:
      return mesh::FitLargest{placement.fit_size_mm()};
    case Placement::kFitBlock:
      return mesh::FitBox{mesh::SizeBeforeTurns(Vec3Of(block.size_mm()),
                                                static_cast<int>(block.quarter_turns())) -
                          Vec3::Constant(2 * block.margin_mm())};
    case Placement::FIT_NOT_SET:
      break;
  }
  return mesh::NoFit{};
}

/// A frozen job of a version without this field has none: its models were taken as they
/// lie in their files.
mesh::UpAxis UpOf(UpAxis up, std::optional<mesh::UpAxis> declared) {
  switch (up) {
    case UP_AXIS_Y:
      return mesh::UpAxis::kY;
    case UP_AXIS_X:
      return mesh::UpAxis::kX;
    case UP_AXIS_MINUS_Z:
      return mesh::UpAxis::kMinusZ;
    case UP_AXIS_MINUS_Y:
      return mesh::UpAxis::kMinusY;
    case UP_AXIS_MINUS_X:
      return mesh::UpAxis::kMinusX;
    case UP_AXIS_DECLARED:
      return declared.value_or(mesh::UpAxis::kZ);
    default:
      return mesh::UpAxis::kZ;
  }
}

}  // namespace

Vec3 Vec3Of(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

Vec3 BlockSizeOf(const JobSpec& job) { return Vec3Of(job.block().size_mm()); }

Box3 PermittedBoxOf(const Block& block) {
  Require(block.has_margin_mm(), "the job's defaults are not filled in");
  const Vec3 margin_mm = Vec3::Constant(block.margin_mm());
  return {margin_mm, Vec3Of(block.size_mm()) - margin_mm};
}

mesh::Placement PlacementOf(const Placement& placement, const Block& block,
                            std::optional<mesh::UpAxis> declared) {
  Require(placement.has_scale_ratio() && block.has_margin_mm(),
          "the job's defaults are not filled in");
  mesh::Placement result;
  if (placement.has_unit_mm()) result.unit_mm = placement.unit_mm();
  result.up = UpOf(placement.up(), declared);
  result.mirror_x = placement.mirror_x();
  result.mirror_y = placement.mirror_y();
  result.mirror_z = placement.mirror_z();
  result.scale_ratio = Vec3Of(placement.scale_ratio());
  result.rotation_rad = Vec3Of(placement.rotate_deg()) * kRadPerDegree;
  result.fit = FitOf(placement, block);
  result.move_mm = Vec3Of(placement.move_mm());
  result.quarter_turns = static_cast<int>(block.quarter_turns());
  result.centre_in_block = placement.centre_in_block();
  result.pivot = placement.pivot() == PIVOT_OBJECT  ? mesh::Pivot::kObject
                 : placement.pivot() == PIVOT_BLOCK ? mesh::Pivot::kBlock
                                                    : mesh::Pivot::kOrigin;
  return result;
}

optics::Lens LensOf(const JobSpec& job) {
  Require(job.lens().has_numerical_aperture(), "the job's defaults are not filled in");
  return {job.lens().focal_length_mm(), job.lens().numerical_aperture()};
}

}  // namespace intaglio
