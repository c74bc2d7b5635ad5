#include "services/drivers/linuxcnc/row_jog.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

namespace intaglio::drivers {
namespace {

constexpr double kPeriodOfJog_s = 0.001;
const Vec3 kMaxSpeed(100, 50, 20), kMaxAcceleration(2000, 1000, 500);

std::vector<Vec3> PlacesOf(const Vec3& from, const Vec3& to, double speed_mm_s) {
  RowJog jog;
  jog.Begin(from, to, speed_mm_s, kMaxSpeed, kMaxAcceleration);
  std::vector<Vec3> places = {from};
  while (jog.active() && places.size() < 100'000)
    places.push_back(jog.Next(kPeriodOfJog_s));
  EXPECT_FALSE(jog.active());
  return places;
}

/// Speeds and accelerations as differences of the places, axis by axis.
void ExpectWithinLimits(const std::vector<Vec3>& places, double speed_mm_s) {
  Vec3 speed = Vec3::Zero();
  for (std::size_t i = 1; i < places.size(); ++i) {
    const Vec3 next = (places[i] - places[i - 1]) / kPeriodOfJog_s;
    EXPECT_LE(next.norm(), speed_mm_s * (1 + 1e-9));
    EXPECT_TRUE((next.array().abs() <= kMaxSpeed.array() * (1 + 1e-9)).all());
    const Vec3 change = (next - speed).cwiseAbs() / kPeriodOfJog_s;
    EXPECT_TRUE((change.array() <= kMaxAcceleration.array() * (1 + 1e-6)).all())
        << i << ": " << change.transpose();
    speed = next;
  }
  // To rest: what is left is less than one period of braking.
  EXPECT_TRUE((speed.array().abs() <= kMaxAcceleration.array() * kPeriodOfJog_s).all());
}

TEST(RowJog, KeepsSpeedAndAccelerationsAndEndsAtItsPlace) {
  for (const Vec3& to : {Vec3(20, 0, 0), Vec3(-7, 3, 1), Vec3(0, 0, -9), Vec3(1, 1, 1)}) {
    for (const double speed_mm_s : {0.5, 25.0, 400.0}) {
      const auto places = PlacesOf(Vec3(1, 2, 3), Vec3(1, 2, 3) + to, speed_mm_s);
      EXPECT_EQ(places.back(), Vec3(Vec3(1, 2, 3) + to));
      ExpectWithinLimits(places, speed_mm_s);
      for (const Vec3& place : places) {
        const Vec3 way = place - Vec3(1, 2, 3);
        EXPECT_LT(way.cross(to).norm(), 1e-9 * to.squaredNorm()) << "beside the line";
      }
    }
  }
}

// 20 mm at 25 mm/s with 2000 mm/s^2 take 20 / 25 + 25 / 2000 s.
TEST(RowJog, TakesTheTimeOfItsSpeed) {
  const auto places = PlacesOf(Vec3::Zero(), Vec3(20, 0, 0), 25);
  EXPECT_NEAR(static_cast<double>(places.size() - 1), 812.5, 1);
}

TEST(RowJog, ToWhereItIsEndsAtOnce) {
  EXPECT_EQ(PlacesOf(Vec3(4, 5, 6), Vec3(4, 5, 6), 25).size(), 2u);
}

}  // namespace
}  // namespace intaglio::drivers
