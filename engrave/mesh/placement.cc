#include "engrave/mesh/placement.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

namespace intaglio::mesh {
namespace {

void CheckPlacement(const Placement& p) {
  Require(p.unit_mm > 0 && std::isfinite(p.unit_mm), "unit_mm must be positive, is {}",
          p.unit_mm);
  Require((p.scale_ratio.array() > 0).all() && p.scale_ratio.allFinite(),
          "scale_ratio must be positive, is ({}, {}, {})", p.scale_ratio.x(),
          p.scale_ratio.y(), p.scale_ratio.z());
  Require(p.rotation_rad.allFinite(), "rotation_rad must be finite, is ({}, {}, {})",
          p.rotation_rad.x(), p.rotation_rad.y(), p.rotation_rad.z());
  Require(p.quarter_turns >= 0 && p.quarter_turns <= 3,
          "quarter_turns must be 0..3, is {}", p.quarter_turns);
  Require(p.move_mm.allFinite(), "move_mm must be finite, is ({}, {}, {})", p.move_mm.x(),
          p.move_mm.y(), p.move_mm.z());
}

constexpr double kHalfPi = 1.5707963267948966;

/// A turn by `angle_rad` about axis 0, 1 or 2 (x, y, z), counter-clockwise: exact where
/// the angle is a multiple of a right angle, so that a box stays a box.
Mat3 TurnAbout(int axis, double angle_rad) {
  double cosine = std::cos(angle_rad);
  double sine = std::sin(angle_rad);
  const double quarters = angle_rad / kHalfPi;
  if (std::abs(quarters) < 1e6 && quarters == std::round(quarters)) {
    cosine = std::round(cosine);
    sine = std::round(sine);
  }
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  Mat3 turn = Mat3::Identity();
  turn(u, u) = cosine;
  turn(u, v) = -sine;
  turn(v, u) = sine;
  turn(v, v) = cosine;
  return turn;
}

/// Steps 1 to 5.
Mat3 TurnedFromModel(const Placement& p) {
  const Vec3 sign(p.mirror_x ? -1 : 1, p.mirror_y ? -1 : 1, p.mirror_z ? -1 : 1);
  const Vec3 stretch = p.unit_mm * p.scale_ratio.cwiseProduct(sign);
  return RotationOf(p.rotation_rad) * Mat3(stretch.asDiagonal()) * UprightFrom(p.up);
}

Box3 BoundsAfter(const Mat3& linear, const PointList& vertices) {
  Box3 box;
  for (const Vec3& v : vertices) box.Extend(linear * v);
  return box;
}

/// The pivot of the upright model, mm.
Vec3 PivotOf(const Placement& p, const PointList& vertices, const Vec3& block_size_mm) {
  switch (p.pivot) {
    case Pivot::kOrigin:
      break;
    case Pivot::kObject:
      return p.unit_mm * BoundsAfter(UprightFrom(p.up), vertices).center_mm();
    case Pivot::kBlock:
      return 0.5 * block_size_mm;
  }
  return Vec3::Zero();
}

Result<double> RatioTo(double wanted_mm, double extent_mm, const char* extent_name) {
  Require(wanted_mm > 0 && std::isfinite(wanted_mm),
          "a fit's size must be positive, is {}", wanted_mm);
  if (!(extent_mm > 0)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the model has no {} to fit to {} mm; rotate it or fit its "
                            "largest size instead",
                            extent_name, wanted_mm),
                fmt::format("{}", extent_mm));
  }
  return wanted_mm / extent_mm;
}

/// Step 6: the common factor that brings `size_mm` to the size that the fit requires.
struct FitRatio {
  const Vec3& size_mm;

  Result<double> operator()(const NoFit&) const { return 1.0; }
  Result<double> operator()(const FitHeight& fit) const {
    return RatioTo(fit.height_mm, size_mm.z(), "height (z extent)");
  }
  Result<double> operator()(const FitLargest& fit) const {
    return RatioTo(fit.size_mm, size_mm.maxCoeff(), "extent");
  }
  Result<double> operator()(const FitBox& fit) const {
    Require((fit.size_mm.array() > 0).all() && fit.size_mm.allFinite(),
            "a fit's size must be positive, is ({}, {}, {})", fit.size_mm.x(),
            fit.size_mm.y(), fit.size_mm.z());
    double largest_share = 0;
    int tightest = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double share = size_mm[axis] / fit.size_mm[axis];
      if (share > largest_share) {
        largest_share = share;
        tightest = axis;
      }
    }
    return RatioTo(fit.size_mm[tightest], size_mm[tightest], "extent");
  }
};

}  // namespace

Mat3 RotationOf(const Vec3& rotation_rad) {
  return TurnAbout(2, rotation_rad.z()) * TurnAbout(1, rotation_rad.y()) *
         TurnAbout(0, rotation_rad.x());
}

Vec3 SizeBeforeTurns(const Vec3& block_size_mm, int quarter_turns) {
  Vec3 size_mm = block_size_mm;
  if (quarter_turns % 2 != 0) std::swap(size_mm.x(), size_mm.y());
  return size_mm;
}

Mat3 QuarterTurnsAboutZ(int count) { return TurnAbout(2, count * kHalfPi); }

Mat3 ObjectAxesOf(const Placement& placement) {
  return QuarterTurnsAboutZ(placement.quarter_turns) * RotationOf(placement.rotation_rad);
}

namespace {

/// Step 9: the block's middle stays its middle.
void TurnWithBlock(int quarter_turns, const Vec3& block_size_mm,
                   GlassFromModel& transform) {
  if (quarter_turns == 0) return;
  const Mat3 turn = QuarterTurnsAboutZ(quarter_turns);
  const Vec3 middle_mm = 0.5 * SizeBeforeTurns(block_size_mm, quarter_turns);
  transform.linear = turn * transform.linear;
  transform.offset_mm = turn * (transform.offset_mm - middle_mm) + 0.5 * block_size_mm;
}

}  // namespace

Result<GlassFromModel> GlassFromModelOf(const PointList& vertices,
                                        const Placement& placement,
                                        const Vec3& block_size_mm) {
  CheckPlacement(placement);
  Require(!vertices.empty(), "a model to place must have vertices");
  GlassFromModel transform;
  transform.linear = TurnedFromModel(placement);
  const Vec3 size_mm = BoundsAfter(transform.linear, vertices).size_mm();
  const double ratio = INTAGLIO_TRY(std::visit(FitRatio{size_mm}, placement.fit));
  transform.linear *= ratio;
  transform.offset_mm = placement.move_mm;
  const Vec3 before_mm = SizeBeforeTurns(block_size_mm, placement.quarter_turns);
  if (placement.centre_in_block) {
    const Box3 fitted = BoundsAfter(transform.linear, vertices);
    transform.offset_mm += 0.5 * before_mm - fitted.center_mm();
  } else {
    const Vec3 pivot_mm = PivotOf(placement, vertices, before_mm);
    const Vec3 in_file = UprightFrom(placement.up).transpose() * pivot_mm;
    transform.offset_mm += pivot_mm - transform.linear * (in_file / placement.unit_mm);
  }
  if (!transform.linear.allFinite() || !transform.offset_mm.allFinite()) {
    return Fail(ErrorCode::kInvalidValue,
                "the model's size after scaling is not finite; check its unit and scale");
  }
  TurnWithBlock(placement.quarter_turns, block_size_mm, transform);
  return transform;
}

Result<TriangleMesh> PlaceInBlock(const TriangleMesh& mesh, const Placement& placement,
                                  const Vec3& block_size_mm) {
  const GlassFromModel glass_from_model =
      INTAGLIO_TRY(GlassFromModelOf(mesh.vertices, placement, block_size_mm));
  TriangleMesh placed = mesh;
  for (Vec3& v : placed.vertices) v = glass_from_model.Apply(v);
  const bool mirrored = (placement.mirror_x != placement.mirror_y) != placement.mirror_z;
  if (mirrored) {
    for (Triangle& t : placed.triangles) std::swap(t[1], t[2]);
  }
  return placed;
}

}  // namespace intaglio::mesh
