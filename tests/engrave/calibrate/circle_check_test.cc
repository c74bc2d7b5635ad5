#include "engrave/calibrate/circle_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace intaglio::calibrate {
namespace {

using ::testing::HasSubstr;

/// Points of a circle of 30 mm around (100, -40), each as an axis pair with these errors
/// puts it; counterclockwise (1) or clockwise (-1) at 2000 mm/min.
struct WrongCircle {
  double scale_ratio = 0, squareness_rad = 0, lag_x_s = 0, lag_y_s = 0, noise_mm = 0;
  double direction = 1;

  std::vector<Vec2> Points(int count) const {
    const double rate_rad_s = 2000.0 / 60 / 30 * direction;
    std::mt19937 random(4);
    std::normal_distribution<double> noise(0, std::max(noise_mm, 1e-12));
    std::vector<Vec2> points;
    for (int i = 0; i < count; ++i) {
      const double t = 2 * std::numbers::pi * i / count / std::abs(rate_rad_s);
      const double x = 30 * std::cos(rate_rad_s * (t - lag_x_s));
      const double y = 30 * std::sin(rate_rad_s * (t - lag_y_s));
      points.emplace_back(
          100 + (1 + scale_ratio) * x + squareness_rad * y + noise(random),
          -40 + y + noise(random));
    }
    return points;
  }
};

TEST(CircleCheck, AnExactCircleHasNoDeviation) {
  const auto check = CheckCircle(WrongCircle().Points(360), 30, std::nullopt);
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_NEAR((check->centre_mm - Vec2(100, -40)).norm(), 0, 1e-9);
  EXPECT_NEAR(check->radius_mm, 30, 1e-9);
  EXPECT_NEAR(check->circular_deviation_mm, 0, 1e-9);
  EXPECT_NEAR(check->gap_rad, 2 * std::numbers::pi / 360, 1e-9);
}

// What is left is of the second order in what is set: 1e-6 of 30 mm.
TEST(CircleCheck, HasScaleAndSquarenessOfTheAxes) {
  WrongCircle wrong;
  wrong.scale_ratio = 1e-3;
  wrong.squareness_rad = -4e-4;
  const auto check = CheckCircle(wrong.Points(500), 30, Vec2(100, -40));
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_NEAR(check->scale_ratio, 1e-3, 2e-6);
  EXPECT_NEAR(check->squareness_rad, -4e-4, 2e-6);
  // The oracle is the ellipse: its axes are R (1 + e / 2 +- sqrt(e^2 + s^2) / 2).
  const double half_mm = 30 * std::hypot(1e-3, 4e-4) / 2;
  EXPECT_NEAR(check->circular_deviation_mm, 2 * half_mm, 1e-4);
  EXPECT_NEAR(check->max_radial_mm, 30 * 1e-3 / 2 + half_mm, 1e-4);
  EXPECT_NEAR(check->min_radial_mm, 30 * 1e-3 / 2 - half_mm, 1e-4);
  EXPECT_LT(check->rest_mm, 1e-4);
}

// Loops of unequal gains, lags 1/K of 20 and 24 ms: an ellipse on the diagonals, its
// other diagonal in the other direction (reference: (K1 - K2) / (2 K1 K2) F, in radii).
TEST(CircleCheck, UnequalLagsTurnWithTheDirectionAndSquarenessDoesNot) {
  WrongCircle wrong;
  wrong.lag_x_s = 0.020;
  wrong.lag_y_s = 0.024;
  wrong.squareness_rad = 1e-4;
  const auto left = CheckCircle(wrong.Points(400), 30, std::nullopt);
  wrong.direction = -1;
  const auto right = CheckCircle(wrong.Points(400), 30, std::nullopt);
  ASSERT_TRUE(left && right);
  const double feed_mm_s = 2000.0 / 60;
  EXPECT_NEAR((left->squareness_rad + right->squareness_rad) / 2, 1e-4, 1e-6);
  EXPECT_NEAR((left->squareness_rad - right->squareness_rad) / 2 * 30 / feed_mm_s,
              0.020 - 0.024, 2e-6);
  WrongCircle square = wrong;
  square.squareness_rad = 0;
  const auto alone = CheckCircle(square.Points(400), 30, std::nullopt);
  const double k1 = 1 / 0.020, k2 = 1 / 0.024;
  // Twice the amplitude of the radius.
  EXPECT_NEAR(alone->circular_deviation_mm, 2 * feed_mm_s * (k1 - k2) / (2 * k1 * k2),
              1e-3);
}

TEST(CircleCheck, NoiseIsRestAndDoesNotMoveTheFigures) {
  WrongCircle wrong;
  wrong.scale_ratio = 5e-4;
  wrong.noise_mm = 0.002;
  const auto check = CheckCircle(wrong.Points(720), 30, std::nullopt);
  ASSERT_TRUE(check);
  // 720 points give sigma sqrt(2 / 720) of a, twice over the radius.
  EXPECT_NEAR(check->scale_ratio, 5e-4, 4 * 2 * 0.002 * std::sqrt(2.0 / 720) / 30);
  EXPECT_GT(check->rest_mm, 4 * 0.002);
  EXPECT_LT(check->rest_mm, 10 * 0.002);
}

TEST(CircleCheck, RefusesWhatIsNoWholeCircle) {
  const auto points = WrongCircle().Points(40);
  const auto message = [](const std::vector<Vec2>& of, double radius_mm = 30) {
    const auto check = CheckCircle(of, radius_mm, std::nullopt);
    return check ? std::string() : check.error().message;
  };
  EXPECT_THAT(message({points.begin(), points.begin() + 7}), HasSubstr("too few"));
  EXPECT_THAT(message({points.begin(), points.begin() + 25}),
              HasSubstr("a gap of 144 degrees"));
  EXPECT_THAT(message(points, 0), HasSubstr("a radius of 0 mm"));
  std::vector<Vec2> line;
  for (int i = 0; i < 20; ++i) line.emplace_back(i, 2 * i);
  EXPECT_THAT(message(line), HasSubstr("on no circle"));
  auto broken = points;
  broken[3].y() = std::nan("");
  EXPECT_THAT(message(broken), HasSubstr("point 4 has a coordinate that is no number"));
}

}  // namespace
}  // namespace intaglio::calibrate
