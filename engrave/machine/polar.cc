#include "engrave/machine/polar.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/machine/unreachable.h"

// In the frame of the table at angle 0, O2 (the table's axis) is the origin and O1 (the
// arm's) is at (0, d). A place (u, v) of the block has the distance r from O2 and the
// signed angle beta = atan2(u, v) from the y axis, clockwise; the source's (x, y) are
// u = x - a/2, v = y + y2. The triangle O2 P O1 has the sides r, r1, d, so (134), (135)
//   cos theta2 = (r^2 + d^2 - r1^2) / (2 r d),  cos theta1 = (r1^2 + d^2 - r^2) / (2 r1
//   d).
// The table turned by t counterclockwise has the place at t - beta counterclockwise of
// the line O2 O1. Left: that is theta2, and the arm, which turns from O1 O2, is at
// -theta1 = 2 pi - theta1. Right: that is -theta2, the arm at theta1. The source's cases
// x >= a/2 and x < a/2 are the two signs of beta. Back: the beam is at (r1 sin arm, d -
// r1 cos arm), and the table is turned back by t:
//   u = bx cos t + by sin t,  v = by cos t - bx sin t;
// d(u, v)/dt = (v, -u), and d(bx, by)/d arm = r1 (cos arm, sin arm) is turned back as
// well. A frame that is turned on the table by f is at t + f when the table is at t. The
// determinant of both columns is r1 d sin(arm): singular where the arm lies on the line
// O1 O2, folded (r = |d - r1|) or stretched (r = d + r1).

namespace intaglio::machine {
namespace {

using std::numbers::pi;

double NearestTurn(double angle_rad, double near_rad) {
  return angle_rad + 2 * pi * std::round((near_rad - angle_rad) / (2 * pi));
}

class Polar final : public Kinematics {
 public:
  explicit Polar(const PolarOptions& options)
      : d_mm_(options.axis_distance_mm),
        r1_mm_(options.arm_length_mm),
        left_(options.side == ArmSide::kLeft),
        z_mm_(options.z.per_unit_mm()),
        margin_rad_(options.singular_margin_rad),
        turn_rad_(options.frame_turn_rad) {
    Require(d_mm_ > 0 && r1_mm_ > 0 && std::isfinite(d_mm_ + r1_mm_),
            "axis_distance_mm and arm_length_mm must be positive, are {} and {}", d_mm_,
            r1_mm_);
    Require(margin_rad_ >= 0.01 && margin_rad_ <= 1,
            "singular_margin_rad must be in 0.01..1, is {}", margin_rad_);
    Require(std::abs(turn_rad_) <= 1000, "frame_turn_rad must be in -1000..1000, is {}",
            turn_rad_);
  }

  std::array<Axis, 3> axes() const override {
    return {{{"arm", AxisUnit::kRad}, {"table", AxisUnit::kRad}, {"z"}}};
  }

  Result<Vec3> ToAxes(const Vec3& place_mm, const Vec3& near) const override {
    if (!place_mm.allFinite()) return NoNumber(place_mm);
    const double r_mm = place_mm.head<2>().norm();
    const double cos_theta1 =
        (r1_mm_ * r1_mm_ + d_mm_ * d_mm_ - r_mm * r_mm) / (2 * r1_mm_ * d_mm_);
    if (!(std::abs(cos_theta1) <= std::cos(margin_rad_))) {
      return NotReached(place_mm, r_mm, cos_theta1);
    }
    const double theta1 = std::acos(cos_theta1);
    const double theta2 = std::acos(std::clamp(
        (r_mm * r_mm + d_mm_ * d_mm_ - r1_mm_ * r1_mm_) / (2 * r_mm * d_mm_), -1.0, 1.0));
    const double beta = std::atan2(place_mm.x(), place_mm.y());
    const double arm = left_ ? 2 * pi - theta1 : theta1;
    const double table = (left_ ? theta2 + beta : beta - theta2) - turn_rad_;
    return Vec3(NearestTurn(arm, near.x()), NearestTurn(table, near.y()),
                place_mm.z() / z_mm_);
  }

  Vec3 ToPlace(const Vec3& axes) const override {
    const Vec2 beam(r1_mm_ * std::sin(axes.x()), d_mm_ - r1_mm_ * std::cos(axes.x()));
    const Vec2 place = TurnedBack(beam, axes.y() + turn_rad_);
    return {place.x(), place.y(), z_mm_ * axes.z()};
  }

  Mat3 ScaleAt(const Vec3& axes) const override {
    const Vec2 arm = TurnedBack(r1_mm_ * Vec2(std::cos(axes.x()), std::sin(axes.x())),
                                axes.y() + turn_rad_);
    const Vec3 place = ToPlace(axes);
    Mat3 scale = Mat3::Zero();
    scale.col(0).head<2>() = arm;
    scale.col(1).head<2>() = Vec2(place.y(), -place.x());
    scale(2, 2) = z_mm_;
    return scale;
  }

  // The table moves a place by its distance from the axis per radian; the maximum is at a
  // corner.
  ScaleBounds BoundsOver(const Box3& places_mm) const override {
    Require(!places_mm.empty(), "scale bounds of an empty box");
    const double r_mm = places_mm.min_mm.cwiseAbs()
                            .cwiseMax(places_mm.max_mm.cwiseAbs())
                            .head<2>()
                            .norm();
    ScaleBounds bounds;
    bounds.axis_mm = Vec3(r1_mm_, r_mm, std::abs(z_mm_));
    bounds.any_mm = std::max(std::abs(z_mm_), std::hypot(r1_mm_, r_mm));
    return bounds;
  }

 private:
  static Vec2 TurnedBack(const Vec2& v, double angle_rad) {
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    return {v.x() * c + v.y() * s, v.y() * c - v.x() * s};
  }

  tl::unexpected<Error> NotReached(const Vec3& place_mm, double r_mm,
                                   double cos_theta1) const {
    const auto radius_at = [this](double theta1) {
      return std::sqrt(r1_mm_ * r1_mm_ + d_mm_ * d_mm_ -
                       2 * r1_mm_ * d_mm_ * std::cos(theta1));
    };
    const char* why =
        cos_theta1 > 1    ? "is nearer to the table's axis than the arm reaches"
        : cos_theta1 > 0  ? "is in the singular region of the folded arm"
        : cos_theta1 < -1 ? "is farther from the table's axis than the arm reaches"
                          : "is in the singular region of the stretched arm";
    return Unreachable(
        place_mm,
        fmt::format("{}: it is {:.6g} mm from the table's axis, the arm serves {:.6g} to "
                    "{:.6g} mm; move the block on the table and correct block_origin_mm",
                    why, r_mm, radius_at(margin_rad_), radius_at(pi - margin_rad_)));
  }

  double d_mm_, r1_mm_;
  bool left_;
  double z_mm_, margin_rad_, turn_rad_;
};

}  // namespace

std::shared_ptr<const Kinematics> MakePolar(const PolarOptions& options) {
  return std::make_shared<Polar>(options);
}

}  // namespace intaglio::machine
