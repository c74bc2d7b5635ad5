#include "engrave/optics/machine_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::optics {
namespace {

const MachineFromGlass kFrame{Vec3(10, -20, 5), Vec3(100, 80, 60), 0.65};

TEST(MachineFrame, TopFaceIsWhereTheBlockEndsWhateverTheGlass) {
  const Vec3 top = kFrame.ToMachine(Vec3(30, 40, 60));
  EXPECT_EQ(top, Vec3(40, 20, 65));
}

TEST(MachineFrame, FocusFallsDeeperThanTheStageMoves) {
  const Vec3 top = kFrame.ToMachine(Vec3(0, 0, 60));
  const Vec3 deep = kFrame.ToMachine(Vec3(0, 0, 20));
  EXPECT_LT(deep.z(), top.z());
  EXPECT_NEAR(top.z() - deep.z(), 0.65 * 40, 1e-12);  // rounding of numbers below 100
}

TEST(MachineFrame, RefractionBringsAParaxialRayToTheSameDepth) {
  // Independent of the ratio's use above: a ray that would meet the axis at the stage's
  // height in air bends at the top face by Snell's law and has to meet it at the point.
  const double index = 1.52;
  const double sine_in_air = 1e-4;
  const MachineFromGlass frame{Vec3::Zero(), Vec3(50, 50, 50), 1 / index};
  for (const double z_mm : {5.0, 25.0, 49.0}) {
    const double air_depth_mm = 50 - frame.ToMachine(Vec3(0, 0, z_mm)).z();
    const double height_on_face_mm = air_depth_mm * std::tan(std::asin(sine_in_air));
    const double glass_depth_mm =
        height_on_face_mm / std::tan(std::asin(sine_in_air / index));
    // Third-order aberration at this aperture is below 1e-8 of the depth.
    EXPECT_NEAR(50 - glass_depth_mm, z_mm, 1e-6);
  }
}

TEST(MachineFrame, ToGlassIsTheInverse) {
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(100, 80, 60), Vec3(12.5, 71.25, 3.0625)}) {
    EXPECT_LT((kFrame.ToGlass(kFrame.ToMachine(p)) - p).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace intaglio::optics
