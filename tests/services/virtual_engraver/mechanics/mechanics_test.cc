#include "services/virtual_engraver/mechanics/mechanics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace intaglio::virtual_engraver {
namespace {

/// x'' + 2 d w x' + w^2 x = w^2 c, classical Runge-Kutta from (x, v) over the command.
void Integrate(const CubicCommand& command, double w, double d, double to_s, int steps,
               Vec3& x, Vec3& v) {
  const double h = to_s / steps;
  const auto slope = [&](double s, const Vec3& at, const Vec3& speed) {
    return Vec3(w * w * (command.At(s) - at) - 2 * d * w * speed);
  };
  for (int i = 0; i < steps; ++i) {
    const double s = i * h;
    const Vec3 a1 = slope(s, x, v), v2 = v + h / 2 * a1;
    const Vec3 a2 = slope(s + h / 2, x + h / 2 * v, v2), v3 = v + h / 2 * a2;
    const Vec3 a3 = slope(s + h / 2, x + h / 2 * v2, v3), v4 = v + h * a3;
    const Vec3 a4 = slope(s + h, x + h * v3, v4);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
}

TEST(Mechanics, SecondOrderFollowsItsEquationWhateverTheDamping) {
  const CubicCommand command = {Vec3(1, -2, 0.5), Vec3(80, -20, 3), Vec3(3500, 200, -90),
                                Vec3(-9e4, 4e4, 1e3)};
  for (const double frequency_hz : {37.0, 120.0, 1500.0}) {
    for (const double damping : {0.05, 0.7, 1.0, 3.0}) {
      Mechanics mechanics({0, SecondOrderOptions{frequency_hz, damping}}, Vec3::Zero());
      Vec3 x = Vec3::Zero(), v = Vec3::Zero();
      // Steps of different lengths, so that none is taken for another.
      double at_s = 0;
      for (const double to_s : {0.002, 0.004, 0.0041, 0.01, 0.02}) {
        mechanics.Follow(command, at_s, to_s);
        at_s = to_s;
      }
      Integrate(command, 2 * std::numbers::pi * frequency_hz, damping, at_s, 40000, x, v);
      // At 1500 Hz a step is 0.005 rad: the error of the integration is below 1e-8.
      EXPECT_LT((mechanics.actual_mm() - x).norm(), 1e-8)
          << frequency_hz << " Hz " << damping;
    }
  }
}

TEST(Mechanics, AtConstantSpeedItIsLateByItsVelocityLag) {
  const CubicCommand command = {Vec3::Zero(), Vec3(80, -10, 0), Vec3::Zero(),
                                Vec3::Zero()};
  for (const auto& second : {std::optional<SecondOrderOptions>(),
                             std::optional(SecondOrderOptions{120, 0.7})}) {
    Mechanics mechanics({0.0005, second}, Vec3::Zero());
    mechanics.Follow(command, 0, 0.2);
    const double lag_s = second ? 2 * 0.7 / (2 * std::numbers::pi * 120) : 0.0005;
    EXPECT_LT((mechanics.velocity_lag_s() - Vec3::Constant(lag_s)).norm(), 1e-15);
    EXPECT_LT((mechanics.actual_mm() - command.At(0.2 - lag_s)).norm(), 1e-9);
  }
}

// Each axis is as if all were driven like it.
TEST(Mechanics, AxesMayBeDrivenEachInItsOwnWay) {
  const MechanicsOptions lag = {0.0005}, spring = {0, SecondOrderOptions{80, 0.4}},
                         servo = {0, {}, ServoOptions{200, 0.003, 0, 0}};
  MechanicsOptions mixed;
  mixed.of_axis = {lag, spring, servo};
  const CubicCommand command = {Vec3(1, 2, 3), Vec3(80, -10, 5), Vec3(100, 50, -400),
                                Vec3(0, 900, 50)};
  Mechanics axes(mixed, Vec3::Zero());
  axes.Follow(command, 0, 0.004);
  axes.Follow(command, 0.004, 0.02);
  int axis = 0;
  for (const MechanicsOptions& options : mixed.of_axis) {
    Mechanics alike(options, Vec3::Zero());
    alike.Follow(command, 0, 0.004);
    alike.Follow(command, 0.004, 0.02);
    EXPECT_EQ(axes.actual_mm()[axis], alike.actual_mm()[axis]) << axis;
    EXPECT_EQ(axes.velocity_lag_s()[axis], alike.velocity_lag_s()[axis]) << axis;
    ++axis;
  }
  EXPECT_FALSE(mixed.first_order());
  EXPECT_TRUE(lag.first_order());
  EXPECT_FALSE(Undisturbed(lag).has_value());
  EXPECT_TRUE(Undisturbed(mixed).has_value()) << "the servo has a limit and friction";
}

TEST(Mechanics, AStuckAxisStaysAndStartsAgainFromRest) {
  Mechanics mechanics({0, SecondOrderOptions{50, 0.3}}, Vec3::Zero());
  const CubicCommand step = {Vec3(1, 1, 1), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  mechanics.Follow(step, 0, 0.003);
  const double stuck_mm = mechanics.actual_mm().y();
  mechanics.Stick(1);
  mechanics.Follow(step, 0, 0.05);
  EXPECT_EQ(mechanics.actual_mm().y(), stuck_mm);
  mechanics.Unstick();
  mechanics.Follow(step, 0, 1e-6);
  // From rest it goes (w dt)^2 / 2 of the way; with its old speed it would go 250 times
  // as far.
  EXPECT_LT(mechanics.actual_mm().y() - stuck_mm, 1e-7);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
