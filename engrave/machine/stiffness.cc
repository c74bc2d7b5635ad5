#include "engrave/machine/stiffness.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio::machine {
namespace {

using Plane = Eigen::Matrix2d;

Plane InPlane(const Kinematics& kinematics, const Vec3& axes) {
  return kinematics.ScaleAt(axes).topLeftCorner<2, 2>();
}

}  // namespace

double SourceStiffness(StiffnessRule rule, double first, double second) {
  Require(first > 0 && second > 0, "stiffness must be positive, is {} and {}", first,
          second);
  switch (rule) {
    case StiffnessRule::kSeries:
      return first * second / (first + second);
    case StiffnessRule::kIndependent:
      return std::min(first, second);
    case StiffnessRule::kParallel:
      break;
  }
  return first + second;
}

PlaneScale PlaneScaleAt(const Kinematics& kinematics, const Vec3& axes) {
  const auto sizes =
      Eigen::JacobiSVD<Plane>(InPlane(kinematics, axes)).singularValues().eval();
  return {sizes[1], sizes[0]};
}

double WeakestStiffness(const Kinematics& kinematics, const Vec3& axes,
                        const Vec2& stiffness) {
  Require(stiffness.minCoeff() > 0, "stiffness must be positive, is {} and {}",
          stiffness[0], stiffness[1]);
  const Plane scale = InPlane(kinematics, axes);
  const Plane yields = scale * stiffness.cwiseInverse().asDiagonal() * scale.transpose();
  return 1 / Eigen::SelfAdjointEigenSolver<Plane>(yields).eigenvalues().maxCoeff();
}

}  // namespace intaglio::machine
