#include "engrave/machine/cartesian.h"

#include <Eigen/SVD>
#include <cmath>

#include "engrave/machine/unreachable.h"

// A head at h has the focus at h; a table at t has the block moved by t, so the focus at
// -t of it. With u = (m_x x, m_y y, m_z z), m the signed moves for a unit of each axis,
// and q = squareness_xy_rad the place is
//   (u_x + u_y sin q, u_y cos q, u_z).
// Without corrections (m = +-1, q = 0) only signs change, so every bit of a coordinate is
// kept.

namespace intaglio::machine {
namespace {

class Cartesian final : public Kinematics {
 public:
  explicit Cartesian(const CartesianOptions& options)
      : per_unit_mm_(options.x.per_unit_mm(), options.y.per_unit_mm(),
                     options.z.per_unit_mm()),
        sine_(std::sin(options.squareness_xy_rad)),
        cosine_(std::cos(options.squareness_xy_rad)) {}

  std::array<Axis, 3> axes() const override { return {{{"x"}, {"y"}, {"z"}}}; }

  Result<Vec3> ToAxes(const Vec3& place_mm, const Vec3& /*near*/) const override {
    if (!place_mm.allFinite()) return NoNumber(place_mm);
    const double along_y_mm = place_mm.y() / cosine_;
    const Vec3 moved_mm(place_mm.x() - sine_ * along_y_mm, along_y_mm, place_mm.z());
    return Vec3(moved_mm.cwiseQuotient(per_unit_mm_));
  }
  Vec3 ToPlace(const Vec3& axes) const override {
    const Vec3 moved_mm = per_unit_mm_.cwiseProduct(axes);
    return {moved_mm.x() + sine_ * moved_mm.y(), cosine_ * moved_mm.y(), moved_mm.z()};
  }
  Mat3 ScaleAt(const Vec3& /*axes*/) const override {
    Mat3 scale = per_unit_mm_.asDiagonal();
    scale(0, 1) = sine_ * per_unit_mm_.y();
    scale(1, 1) = cosine_ * per_unit_mm_.y();
    return scale;
  }
  ScaleBounds BoundsOver(const Box3& /*places_mm*/) const override {
    ScaleBounds bounds;
    bounds.axis_mm = per_unit_mm_.cwiseAbs();
    bounds.any_mm = sine_ == 0 ? bounds.axis_mm.maxCoeff()
                               : ScaleAt({}).jacobiSvd().singularValues().maxCoeff();
    return bounds;
  }

 private:
  Vec3 per_unit_mm_;
  double sine_, cosine_;
};

}  // namespace

std::shared_ptr<const Kinematics> MakeCartesian(const CartesianOptions& options) {
  return std::make_shared<Cartesian>(options);
}

}  // namespace intaglio::machine
