// Mirrors, lens and web of the virtual scan head against closed forms.

#include "services/virtual_engraver/head/head_physics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/engrave/galvo/traced_head.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr double kTickSeconds = 1e-5;

TEST(HeadPhysics, MirrorsFollowAStepAsTwoEqualPoles) {
  MirrorServo servo(0.0002);
  for (int i = 1; i <= 100; ++i) {
    // 1 - (1 + t / T) exp(-t / T), T the half of the lag.
    const double t = i * kTickSeconds / 0.0001;
    EXPECT_NEAR(servo.Follow(1, kTickSeconds), 1 - (1 + t) * std::exp(-t), 1e-12);
  }
}

TEST(HeadPhysics, TheLensPutsTheBeamAtTheHeightOfItsAngle) {
  HeadPhysicsOptions options;
  options.servo_lag_s = 0;
  options.half_angle_rad = 0.2;
  options.lens_ratio = 0.03;
  HeadPhysics head(options);
  const double focal_mm = 50 / 0.2;
  for (const auto& [x, y] : {std::pair{65535, 32768}, {32768, 0}, {60000, 50000}}) {
    head.PassTick(static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                  kTickSeconds);
    const double ax = (x - 32768.0) * 100 / 65536 / focal_mm;
    const double ay = (y - 32768.0) * 100 / 65536 / focal_mm;
    // The direction behind two mirrors: (sin ax cos ay, sin ay, cos ax cos ay).
    const double angle = std::acos(std::cos(ax) * std::cos(ay));
    const double height_mm = focal_mm * angle * (1 + 0.03 * angle * angle / (0.2 * 0.2));
    EXPECT_NEAR(head.PlaceInField().norm(), height_mm, 1e-6);
    EXPECT_NEAR(head.PlaceInField().x() * std::sin(ay),
                head.PlaceInField().y() * std::sin(ax) * std::cos(ay), 1e-9);
  }
}

// The head by which tests of engrave/galvo judge corrections is another trace.
TEST(HeadPhysics, AgreesWithTheTracedHead) {
  HeadPhysicsOptions options;
  options.servo_lag_s = 0;
  options.half_angle_rad = 20 * std::numbers::pi / 180;
  options.lens_ratio = 0.03;
  HeadPhysics head(options);
  const double focal_mm = 50 / options.half_angle_rad;
  const double cubic_mm =
      focal_mm * 0.03 / options.half_angle_rad / options.half_angle_rad;
  for (int x = 0; x < 65536; x += 5003) {
    for (int y = 0; y < 65536; y += 4001) {
      head.PassTick(static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                    kTickSeconds);
      const Vec2 traced_mm = galvo::TracedThroughLens(
          (x - 32768.0) * 100 / 65536 / focal_mm, (y - 32768.0) * 100 / 65536 / focal_mm,
          {focal_mm, 0, cubic_mm, 0});
      EXPECT_LT((head.PlaceInField() - traced_mm).norm(), 1e-6) << x << " " << y;
    }
  }
}

TEST(HeadPhysics, TheMaterialMovesWithTheWebAndTheEncoderCountsIt) {
  HeadPhysicsOptions options;
  options.web_mm_s = 200;
  HeadPhysics head(options);
  for (int i = 0; i < 100000; ++i) head.PassTick(32768, 32768, kTickSeconds);
  EXPECT_NEAR(head.PlaceOnMaterial().x(), -200, 1e-6);
  EXPECT_NEAR(static_cast<double>(head.ReadEncoder()), 200 / 0.023, 1);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
