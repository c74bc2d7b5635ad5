#include "engrave/machine/stiffness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::machine {
namespace {

// Trochimczuk 2008, (136) to (138).
TEST(Stiffness, TheSourceRanksScrewPlanarAndPolar) {
  EXPECT_DOUBLE_EQ(SourceStiffness(StiffnessRule::kSeries, 40, 60), 24);
  EXPECT_DOUBLE_EQ(SourceStiffness(StiffnessRule::kIndependent, 50, 50), 50);
  EXPECT_DOUBLE_EQ(SourceStiffness(StiffnessRule::kParallel, 40, 60), 100);
  for (const double first : {10.0, 40.0}) {
    const double second = first;
    EXPECT_LT(SourceStiffness(StiffnessRule::kSeries, first, second),
              SourceStiffness(StiffnessRule::kIndependent, first, second));
    EXPECT_LT(SourceStiffness(StiffnessRule::kIndependent, first, second),
              SourceStiffness(StiffnessRule::kParallel, first, second));
  }
  EXPECT_THROW(SourceStiffness(StiffnessRule::kSeries, 0, 1), PreconditionError);
}

TEST(Stiffness, CrossedLinearAxesAreAsStiffAsTheWeaker) {
  const auto linear = MakeKinematics(CartesianOptions{});
  EXPECT_NEAR(WeakestStiffness(*linear, Vec3::Zero(), Vec2(4e4, 6e4)), 4e4, 1e-6);
  const PlaneScale scale = PlaneScaleAt(*linear, Vec3(3, 4, 5));
  EXPECT_DOUBLE_EQ(scale.min_mm, 1);
  EXPECT_DOUBLE_EQ(scale.max_mm, 1);
}

/// How far the focus yields when springs hold both axes of the machine and a force pulls
/// it along `angle_rad`: the turns that make the energy of springs minus work least, by
/// small steps downhill of ToPlace itself.
double YieldedMm(const Kinematics& kinematics, const Vec3& at, const Vec2& stiffness,
                 double angle_rad, double force_n) {
  const Vec2 pull = force_n * Vec2(std::cos(angle_rad), std::sin(angle_rad));
  const Vec2 from = kinematics.ToPlace(at).head<2>();
  const auto energy = [&](const Vec2& turned) {
    const Vec3 axes(at.x() + turned.x(), at.y() + turned.y(), at.z());
    return 0.5 * turned.cwiseAbs2().dot(stiffness) -
           pull.dot(kinematics.ToPlace(axes).head<2>() - from);
  };
  Vec2 turned = Vec2::Zero();
  double step = 1e-4;
  while (step > 1e-12) {
    Vec2 best = turned;
    for (const Vec2& way :
         {Vec2(step, 0), Vec2(-step, 0), Vec2(0, step), Vec2(0, -step)}) {
      if (energy(turned + way) < energy(best)) best = turned + way;
    }
    if (best == turned) step /= 2;
    turned = best;
  }
  const Vec3 axes(at.x() + turned.x(), at.y() + turned.y(), at.z());
  return (kinematics.ToPlace(axes).head<2>() - from).dot(pull) / force_n;
}

TEST(Stiffness, OfArmAndTableIsThatOfTheSpringsInBothAxes) {
  PolarOptions options;
  options.axis_distance_mm = 200;
  options.arm_length_mm = 150;
  const auto polar = MakeKinematics(options);
  const Vec2 stiffness(2e9, 5e9);  // N mm/rad
  const Vec3 axes = polar->ToAxes(Vec3(10, 120, 0), Vec3(5, 0, 0)).value();
  const double force_n = 50;
  double largest_mm = 0;
  for (int i = 0; i < 180; ++i) {
    const double angle_rad = i * std::numbers::pi / 180;
    largest_mm =
        std::max(largest_mm, YieldedMm(*polar, axes, stiffness, angle_rad, force_n));
  }
  // A degree beside the weakest direction loses 3e-4 of it; turns of 1e-6 bend the arc.
  EXPECT_NEAR(force_n / largest_mm, WeakestStiffness(*polar, axes, stiffness),
              1e-3 * force_n / largest_mm);
  // Either alone is stiffer than both, which the source's sum contradicts.
  const double arm = stiffness[0] / (150.0 * 150.0);
  EXPECT_LT(force_n / largest_mm, arm);
}

// The area that a small circle of the axes becomes is r1 d sin(arm): 0 where the arm lies
// on the line of both axes.
TEST(Stiffness, TheScaleOfAPolarMachineVanishesTowardsItsSingularRegion) {
  PolarOptions options;
  options.axis_distance_mm = 200;
  options.arm_length_mm = 150;
  const auto polar = MakeKinematics(options);
  for (const double arm : {3.3, 4.0, 4.7, 5.5, 6.1}) {
    const PlaneScale scale = PlaneScaleAt(*polar, Vec3(arm, 0.3, 0));
    EXPECT_NEAR(scale.min_mm * scale.max_mm, 200 * 150 * std::abs(std::sin(arm)), 1e-6);
  }
}

}  // namespace
}  // namespace intaglio::machine
