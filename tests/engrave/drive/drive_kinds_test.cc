#include "engrave/drive/drive_kinds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/drive/first_order.h"
#include "engrave/drive/loop_kinds.h"
#include "engrave/drive/second_order.h"

namespace intaglio::drive {
namespace {

TEST(DriveKinds, EachRowMakesTheDriveOfItsName) {
  for (const DriveKind& kind : DriveKinds()) {
    std::vector<double> values;
    for (const DriveParameter& parameter : kind.parameters)
      values.push_back(0.999 * parameter.min + 0.001 * parameter.max);
    const auto made = MakeDrive(kind.name, values);
    ASSERT_TRUE(made.has_value());
    EXPECT_EQ((*made)->name(), kind.name);
  }
}

TEST(DriveKinds, AnUnknownNameListsTheKnownOnes) {
  const auto made = MakeDrive("magnetic", {});
  ASSERT_FALSE(made.has_value());
  EXPECT_EQ(made.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(made.error().message,
            "drive magnetic: no such drive; known: first_order, second_order, servo, "
            "cascade, stepper_screw, planar_drive");
}

TEST(DriveKinds, TheNumberOfValuesIsChecked) {
  const double values[] = {100, 0.7, 1};
  for (const std::size_t count : {0, 1, 3}) {
    const auto made = MakeDrive("second_order", std::span(values).first(count));
    ASSERT_FALSE(made.has_value()) << count;
    EXPECT_EQ(made.error().code, ErrorCode::kInvalidValue);
  }
}

TEST(DriveKinds, MadeWithoutTheRegistryWrongValuesThrow) {
  EXPECT_THROW(FirstOrder(-1e-9), PreconditionError);
  EXPECT_THROW(SecondOrder(100, 0), PreconditionError);
  EXPECT_THROW(SecondOrder(0, 0.7), PreconditionError);
}

// The sampled controller itself, stepped exactly: a held acceleration moves the axis as a
// parabola.
double SwingOf(const std::vector<double>& values, double period_s) {
  const double w = 2 * std::numbers::pi * values[0], d = values[1], r = values[2];
  double x = 1, v = 0, held = 0, last = 0, before = 0, late = 0;
  const int periods = static_cast<int>(60 / std::min(w * d, r) / period_s);
  for (int i = 0; i < periods; ++i) {
    const double error = -x;
    held += w * w * r * period_s * error + (w * w + 2 * d * w * r) * (error - last) +
            (2 * d * w + r) / period_s * (error - 2 * last + before);
    before = last;
    last = error;
    x += v * period_s + held * period_s * period_s / 2;
    v += held * period_s;
    if (i > periods * 9 / 10) late = std::max(late, std::abs(x));
    if (!(std::abs(x) < 1e6)) return 1e6;
  }
  return late;
}

TEST(DriveKinds, APlanarDriveIsRefusedWhereItSwings) {
  for (std::vector<double> values : {std::vector{80.0, 0.7, 20.0, 0.0},
                                     {50.0, 0.3, 100.0, 0.0},
                                     {300.0, 1.5, 50.0, 0.0}}) {
    const double longest_s = LongestPeriodS({values[0], values[1], values[2]});
    EXPECT_LT(SwingOf(values, 0.97 * longest_s), 0.1) << values[0];
    EXPECT_GT(SwingOf(values, 1.03 * longest_s), 1) << values[0];
    values[3] = 0.99 * longest_s / kStabilityReserveRatio;
    EXPECT_TRUE(MakeDrive("planar_drive", values).has_value());
    values[3] = 1.01 * longest_s / kStabilityReserveRatio;
    const auto made = MakeDrive("planar_drive", values);
    ASSERT_FALSE(made.has_value());
    EXPECT_NE(made.error().message.find("period_s"), std::string::npos);
  }
}

TEST(DriveKinds, OtherMechanicsAreThoseOfTheRatios) {
  const auto second = MakeDriveWith({1.05, 0.8}, {"second_order", {100, 0.5}}).value();
  const auto expected = MakeDrive("second_order", std::vector{105.0, 0.4}).value();
  EXPECT_EQ(second->transfer().denominator, expected->transfer().denominator);
  // K / tau = w^2 and (1 + D)^2 / (4 K tau) = damping^2.
  const double k = 300, tau = 0.002;
  const Transfer servo =
      MakeDriveWith({1.05, 0.8}, {"servo", {k, tau, 0, 0}}).value()->transfer();
  EXPECT_NEAR(1 / servo.denominator[2], 1.05 * 1.05 * k / tau, 1e-6);
  const double damping = servo.denominator[1] / (2 * std::sqrt(servo.denominator[2]));
  EXPECT_NEAR(damping, 0.8 / (2 * std::sqrt(k * tau)), 1e-9);
}

}  // namespace
}  // namespace intaglio::drive
