#include "engrave/galvo/head_model.h"

#include <Eigen/Geometry>

#include "engrave/galvo/head.h"

namespace intaglio::galvo {

const std::array<const char*, kHeadModelNumbers> kHeadModelNames = {
    "rotation_rad", "zero_x_rad",  "zero_y_rad",  "lens_1_ratio", "lens_3_ratio",
    "lens_4_ratio", "offset_x_mm", "offset_y_mm", "shear_ratio",  "axes_ratio"};

HeadModel HeadModel::Ideal(double focal_mm) {
  return FromNumbers(focal_mm, {0, 0, 0, 1, 0, 0, 0, 0, 0, 1});
}

HeadModel HeadModel::FromNumbers(double focal_mm,
                                 const std::array<double, kHeadModelNumbers>& n) {
  return {focal_mm, n[0], {n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7]}, n[8], n[9]};
}

std::array<double, kHeadModelNumbers> HeadModel::Numbers() const {
  return {rotation_rad,  zero_rad.x(),  zero_rad.y(),  lens_ratio[0], lens_ratio[1],
          lens_ratio[2], offset_mm.x(), offset_mm.y(), shear_ratio,   axes_ratio};
}

Vec2 HeadModel::Arrive(const Vec2& command_mm) const {
  const Head head{
      LensPlace::kBehindMirrors,
      {focal_mm * lens_ratio[0], 0, focal_mm * lens_ratio[1], focal_mm * lens_ratio[2]},
      0,
      0};
  const Vec2 turned_rad(command_mm.x() / focal_mm,
                        axes_ratio * command_mm.y() / focal_mm);
  const Vec2 field_mm = FieldOf(turned_rad + zero_rad, head);
  return Eigen::Rotation2Dd(rotation_rad) * field_mm + offset_mm +
         Vec2(0, shear_ratio * field_mm.x());
}

}  // namespace intaglio::galvo
