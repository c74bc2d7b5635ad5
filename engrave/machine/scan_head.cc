#include "engrave/machine/scan_head.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/machine/unreachable.h"

// A place has the z that the focus of an upright beam would have in air
// (optics/machine_frame.h). Its marginal rays meet at the depth of the point, those near
// its axis at n (top - z), which is less by the spherical aberration; the oblique pencil
// is the thin one with this depth, so that upright beams move as under a stage. Above the
// face the beam is in air, and nothing bends it.
//   f = M^-1 place in the focal plane,  M: place_per_field
//   axes = (f + correction(f), (top - h) / m),  m: move for a unit of z
// With steps of z the height h is the nearest step's, and the field is solved again for
// x and y at that height (Newton, the slopes of x and y alone).
// A correction is added to a place, so its inverse is CommandFor of correction_table.h.

namespace intaglio::machine {
namespace {

/// Of a box, along x and y: as fine as the usual files of corrections over their field.
constexpr int kCorrectionSteps = 64;

class ScanHead final : public Kinematics {
 public:
  explicit ScanHead(const ScanHeadOptions& options)
      : lens_(options.lens),
        corrections_(options.corrections),
        place_per_field_(options.place_per_field),
        field_per_place_(options.place_per_field.inverse()),
        z_mm_(options.z.per_unit_mm()),
        z_step_mm_(options.z_step_mm),
        n_(options.refractive_index),
        top_mm_(options.top_z_mm) {
    Require((lens_.pupil_mm.array() > 0).all(), "pupil_mm must be positive, is {} and {}",
            lens_.pupil_mm.x(), lens_.pupil_mm.y());
    Require(n_ >= 1, "refractive_index must be 1 or more, is {}", n_);
    Require(field_per_place_.allFinite(), "place_per_field must have an inverse");
    Require(z_step_mm_ >= 0, "z_step_mm must not be negative, is {}", z_step_mm_);
  }

  std::array<Axis, 3> axes() const override { return {{{"x"}, {"y"}, {"z"}}}; }

  Result<Vec3> ToAxes(const Vec3& place_mm, const Vec3& /*near*/) const override {
    if (!place_mm.allFinite()) return NoNumber(place_mm);
    const Vec2 across_mm = place_mm.head<2>();
    if (!(lens_.TangentAt(across_mm) <= 1)) return TooSteep(place_mm);
    const double below_mm = top_mm_ - place_mm.z();
    if (below_mm <= 0) return AxesOf(across_mm, place_mm.z());
    const auto solved =
        optics::PositionFor({across_mm.x(), across_mm.y(), n_ * below_mm}, lens_, n_);
    if (!solved) return TooSteep(place_mm);
    return AxesOf(OnStep(solved->head, across_mm).field_mm,
                  top_mm_ - solved->head.below_face_mm);
  }

  Vec3 ToPlace(const Vec3& axes) const override {
    const optics::HeadPosition head = HeadAt(axes);
    if (head.below_face_mm <= 0) {
      return {head.field_mm.x(), head.field_mm.y(), top_mm_ - head.below_face_mm};
    }
    const Vec3 focus_mm = optics::MiddleFocusOf(head, lens_, n_);
    return {focus_mm.x(), focus_mm.y(), top_mm_ - focus_mm.z() / n_};
  }

  Mat3 ScaleAt(const Vec3& axes) const override {
    const optics::HeadPosition head = HeadAt(axes);
    Mat3 scale = Mat3::Identity();
    if (head.below_face_mm > 0) {
      // From (u, v, height) to (x, y, z): both count upward.
      scale = optics::MiddleFocusSlopes(head, lens_, n_);
      scale.topRightCorner<2, 1>() *= -1;
      scale.row(2) /= n_;
      scale.bottomLeftCorner<1, 2>() *= -1;
    }
    scale.leftCols<2>() = scale.leftCols<2>() * PlacePerCommand(head.field_mm);
    scale.col(2) *= z_mm_;
    return scale;
  }

  // The slopes of the optics grow with field and depth, so a corner of the box has the
  // largest; those of corrections may be greatest inside.
  ScaleBounds BoundsOver(const Box3& places_mm) const override {
    Require(!places_mm.empty(), "scale bounds of an empty box");
    const int steps = corrections_ ? kCorrectionSteps : 1;
    ScaleBounds bounds{Vec3::Zero(), 0};
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps; ++j) {
        for (int k = 0; k <= 1; ++k) {
          const Vec3 share(static_cast<double>(i) / steps, static_cast<double>(j) / steps,
                           k);
          const Vec3 place_mm =
              places_mm.min_mm + share.cwiseProduct(places_mm.size_mm());
          const auto axes = ToAxes(place_mm, Vec3::Zero());
          if (axes) Extend(bounds, ScaleAt(*axes));
        }
      }
    }
    // Nothing of the box is reached.
    if (bounds.any_mm == 0) Extend(bounds, Vec3(1, 1, z_mm_).asDiagonal());
    return bounds;
  }

 private:
  static void Extend(ScaleBounds& bounds, const Mat3& scale) {
    bounds.axis_mm = bounds.axis_mm.cwiseMax(scale.colwise().norm().transpose());
    bounds.any_mm =
        std::max(bounds.any_mm, scale.jacobiSvd().singularValues().maxCoeff());
  }

  double OnStep(double z) const {
    return z_step_mm_ > 0 ? std::round(z / z_step_mm_) * z_step_mm_ : z;
  }

  /// At the height of the nearest step, with the focus as far across as it was.
  optics::HeadPosition OnStep(optics::HeadPosition head, const Vec2& across_mm) const {
    if (!(z_step_mm_ > 0)) return head;
    head.below_face_mm =
        std::max(0.0, top_mm_ - z_mm_ * OnStep((top_mm_ - head.below_face_mm) / z_mm_));
    constexpr int kNewtonSteps = 4;
    for (int i = 0; i < kNewtonSteps; ++i) {
      const Vec2 aside_mm = across_mm - optics::MiddleFocusOf(head, lens_, n_).head<2>();
      const Eigen::Matrix2d slopes =
          optics::MiddleFocusSlopes(head, lens_, n_).topLeftCorner<2, 2>();
      head.field_mm += slopes.inverse() * aside_mm;
    }
    return head;
  }

  Result<Vec3> AxesOf(const Vec2& place_mm, double height_mm) const {
    const Vec2 field_mm = field_per_place_ * place_mm;
    const Vec2 command_mm =
        corrections_ ? Vec2(field_mm + galvo::ContinuedAt(*corrections_, field_mm))
                     : field_mm;
    return Vec3(command_mm.x(), command_mm.y(), OnStep(height_mm / z_mm_));
  }

  optics::HeadPosition HeadAt(const Vec3& axes) const {
    const Vec2 command_mm = axes.head<2>();
    const double below_mm = top_mm_ - z_mm_ * axes.z();
    if (!corrections_) return {place_per_field_ * command_mm, below_mm};
    // A table whose corrections change as fast as the place has no inverse; profiles
    // cannot give one.
    const Vec2 field_mm =
        galvo::CommandFor(command_mm, *corrections_).value_or(command_mm);
    return {place_per_field_ * field_mm, below_mm};
  }

  /// The place in the focal plane for a command: M times the inverse of the derivative of
  /// f + correction(f), by differences.
  Eigen::Matrix2d PlacePerCommand(const Vec2& place_mm) const {
    if (!corrections_) return place_per_field_;
    const Vec2 field_mm = field_per_place_ * place_mm;
    Eigen::Matrix2d command = Eigen::Matrix2d::Identity();
    constexpr double kStepMm = 1e-3;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec2 step_mm = kStepMm * Vec2::Unit(axis);
      command.col(axis) += (galvo::ContinuedAt(*corrections_, field_mm + step_mm) -
                            galvo::ContinuedAt(*corrections_, field_mm - step_mm)) /
                           (2 * kStepMm);
    }
    return place_per_field_ * command.inverse();
  }

  tl::unexpected<Error> TooSteep(const Vec3& place_mm) const {
    return Unreachable(
        place_mm,
        fmt::format("needs a beam steeper than 45 degrees: it is {:.6g} mm from the axis "
                    "of the lens, whose pupil is {:.6g} mm away; move the block under "
                    "the lens and correct block_origin_mm",
                    place_mm.head<2>().norm(), lens_.pupil_mm.minCoeff()));
  }

  optics::ScanLens lens_;
  std::shared_ptr<const galvo::CorrectionTable> corrections_;
  Eigen::Matrix2d place_per_field_, field_per_place_;
  double z_mm_, z_step_mm_, n_, top_mm_;
};

}  // namespace

Eigen::Matrix2d FieldMatrix(double x_ratio, double y_ratio, double squareness_rad,
                            double rotation_rad) {
  Eigen::Matrix2d skewed;
  skewed << x_ratio, y_ratio * std::sin(squareness_rad), 0,
      y_ratio * std::cos(squareness_rad);
  return Eigen::Rotation2Dd(rotation_rad).toRotationMatrix() * skewed;
}

std::shared_ptr<const Kinematics> MakeScanHead(const ScanHeadOptions& options) {
  return std::make_shared<ScanHead>(options);
}

}  // namespace intaglio::machine
