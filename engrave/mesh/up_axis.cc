#include "engrave/mesh/up_axis.h"

#include <array>
#include <cmath>
#include <string>

#include "engrave/core/check.h"
#include "engrave/io/lower_case.h"
#include "engrave/mesh/up_convention.h"

namespace intaglio::mesh {
namespace {

struct Row {
  UpAxis up;
  std::string_view name;
  int axis;
  double sign;
};

constexpr std::array<Row, 6> kRows = {{{UpAxis::kX, "x", 0, 1},
                                       {UpAxis::kY, "y", 1, 1},
                                       {UpAxis::kZ, "z", 2, 1},
                                       {UpAxis::kMinusX, "-x", 0, -1},
                                       {UpAxis::kMinusY, "-y", 1, -1},
                                       {UpAxis::kMinusZ, "-z", 2, -1}}};

const Row& RowOf(UpAxis up) {
  for (const Row& row : kRows) {
    if (row.up == up) return row;
  }
  throw PreconditionError("an up axis that is none of the six");
}

Mat3 UprightFromPositive(int axis) {
  Mat3 turn = Mat3::Identity();
  if (axis == 1) turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  if (axis == 0) turn << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return turn;
}

}  // namespace

std::string_view NameOf(UpAxis up) { return RowOf(up).name; }

Vec3 DirectionOf(UpAxis up) { return RowOf(up).sign * Vec3::Unit(RowOf(up).axis); }

UpAxis NearestUpAxis(const Vec3& direction) {
  Require(direction.squaredNorm() > 0, "a direction of no length");
  const Row* nearest = kRows.data();
  for (const Row& row : kRows) {
    if (row.sign * direction[row.axis] > nearest->sign * direction[nearest->axis]) {
      nearest = &row;
    }
  }
  return nearest->up;
}

Mat3 UprightFrom(UpAxis up) {
  const Row& row = RowOf(up);
  const Mat3 turn = UprightFromPositive(row.axis);
  if (row.sign > 0) return turn;
  const Vec3 half_turn = row.axis == 0 ? Vec3(-1, -1, 1) : Vec3(1, -1, -1);
  return turn * Mat3(half_turn.asDiagonal());
}

UpConvention UpConventionOf(std::string_view extension) {
  const std::string lower = io::LowerCaseExtension(extension);
  if (lower == "obj") return UpConvention::kMostlyY;
  return lower == "ply" ? UpConvention::kYOrZ : UpConvention::kZ;
}

}  // namespace intaglio::mesh
