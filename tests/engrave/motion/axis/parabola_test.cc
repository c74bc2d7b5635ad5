#include "engrave/motion/axis/parabola.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "engrave/core/check.h"
#include "tests/published/parabola_controls.h"

namespace intaglio::motion {
namespace {

/// Length of the parabola's polygon of many chords, by Pythagoras alone.
double PolygonLength(double b, double h, double until_mm) {
  constexpr int kChords = 200000;
  const double k = h / (b * b);
  const auto x3 = [&](double x5) { return h - k * (x5 - b) * (x5 - b); };
  double length = 0.0;
  const double dx = until_mm / kChords;
  for (int i = 0; i < kChords; ++i) {
    length += std::hypot(dx, x3((i + 1) * dx) - x3(i * dx));
  }
  return length;
}

/// (47) with the upper end x5, from the apex to both sides: (y sqrt(1 + w^2) +
/// asinh(w) / 2k) / 2 with w = 2 k y.
double PrintedLength(double b, double h, double until_mm) {
  const double k = h / (b * b);
  const auto half = [&](double y) {
    const double w = 2 * k * y;
    return 0.5 * y * (std::sqrt(1 + w * w) + (w == 0.0 ? 1.0 : std::asinh(w) / w));
  };
  return half(b) + half(until_mm - b);
}

TEST(Parabola, JoinsItsEndsAndRisesByItsHeight) {
  const Parabola parabola(3.0, 0.7);
  EXPECT_EQ(parabola.X3(0.0), 0.0);
  EXPECT_EQ(parabola.X3(6.0), 0.0);
  EXPECT_DOUBLE_EQ(parabola.X3(3.0), 0.7);
  EXPECT_DOUBLE_EQ(parabola.X3(1.0), 0.7 - 0.7 / 9.0 * 4.0);
  EXPECT_NEAR(parabola.Slope(1.0),
              (parabola.X3(1.0 + 1e-6) - parabola.X3(1.0 - 1e-6)) / 2e-6, 1e-9);
}

TEST(Parabola, LengthIsThePrintedFormulaAndThePolygons) {
  for (const double h : {1e-6, 0.01, 0.3, 2.0, 40.0}) {
    const double b = 2.5;
    const Parabola parabola(b, h);
    const double q = 2 * b * h / (b * b);
    const double root = std::sqrt(1 + q * q);
    const double printed = (q * root + std::log(q + root)) / q * b;  // (58), 1/2k = b/q
    // The printed logarithm loses its digits where the parabola is flat.
    EXPECT_NEAR(parabola.length_mm(), printed, h < 1e-3 ? 1e-9 : 1e-12 * printed);
    // Chords fall short by a relative 1e-10, sums round to 1e-10.
    EXPECT_NEAR(parabola.length_mm(), PolygonLength(b, h, 2 * b), 1e-7);
    EXPECT_NEAR(parabola.X5AtLength(PolygonLength(b, h, 1.7)), 1.7, 1e-7);
    EXPECT_NEAR(PrintedLength(b, h, 1.7), PolygonLength(b, h, 1.7), 1e-7);
  }
  EXPECT_EQ(Parabola(2.5, 0.0).length_mm(), 5.0);
}

TEST(Parabola, TheInverseOfTheLengthIsOne) {
  for (const double h : {0.0, 0.01, 0.5, 30.0}) {
    const Parabola parabola(2.0, h);
    for (int i = 0; i <= 100; ++i) {
      const double x5 = 0.04 * i;
      EXPECT_NEAR(parabola.X5AtLength(PrintedLength(2.0, h, x5)), x5, 1e-13);
    }
    EXPECT_NEAR(parabola.X5AtLength(parabola.length_mm()), 4.0, 1e-14);
    EXPECT_NEAR(parabola.X5AtLength(0.0), 0.0, 1e-14);
  }
}

TEST(Parabola, RefusesWhatIsNone) {
  EXPECT_THROW(Parabola(0.0, 1.0), PreconditionError);
  EXPECT_THROW(Parabola(1.0, -1.0), PreconditionError);
  EXPECT_THROW(Parabola(1.0, std::nan("")), PreconditionError);
}

// ---- The plant under the controls ----

using State = std::array<double, 4>;  // x3 .. x6
using Control = std::function<ParabolaControls(double, const State&)>;

/// The plant as (36) has it for a stage that does not turn, in SI forces.
struct Masses {
  double m2 = 4.0;
  double m3 = 2.5;
  double b2 = 30.0;
  double b3 = 12.0;

  State Rate(const State& x, const ParabolaControls& u) const {
    const double n_per_m = 1000.0;  // accelerations in mm/s^2
    return {x[1], n_per_m * (u.u4_n - b2 * x[1] / n_per_m) / (m2 + m3), x[3],
            n_per_m * (u.u6_n - b3 * x[3] / n_per_m) / m3};
  }
};

ParabolaState Of(const State& x) { return {x[0], x[1], x[2], x[3]}; }

State Sum(const State& x, double factor, const State& rate) {
  State sum;
  for (std::size_t i = 0; i < 4; ++i) sum[i] = x[i] + factor * rate[i];
  return sum;
}

/// One step of Runge and Kutta, 4th order.
State Advance(const Masses& masses, const Control& control, double t, const State& x,
              double dt) {
  const auto rate = [&](double at, const State& state) {
    return masses.Rate(state, control(at, state));
  };
  const State k1 = rate(t, x);
  const State k2 = rate(t + dt / 2, Sum(x, dt / 2, k1));
  const State k3 = rate(t + dt / 2, Sum(x, dt / 2, k2));
  const State k4 = rate(t + dt, Sum(x, dt, k3));
  State next = x;
  for (std::size_t i = 0; i < 4; ++i) {
    next[i] += dt / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
  return next;
}

constexpr double kWidth = 5.0;   // 2 b, mm
constexpr double kHeight = 1.2;  // mm

/// The printed parabola, not the class's.
double OffParabola(const State& x) {
  const double b = kWidth / 2;
  return x[0] - (kHeight - kHeight / (b * b) * (x[2] - b) * (x[2] - b));
}

const PrintedParabola kPrinted{kWidth / 2, kHeight};

/// The class' state there, within `tolerance` in mm and a thousand times that in mm/s.
void ExpectState(const State& x, const ParabolaState& wanted, double tolerance) {
  ASSERT_NEAR(x[0], wanted.x3_mm, tolerance);
  ASSERT_NEAR(x[1], wanted.x4_mm_s, 1000 * tolerance);
  ASSERT_NEAR(x[2], wanted.x5_mm, tolerance);
  ASSERT_NEAR(x[3], wanted.x6_mm_s, 1000 * tolerance);
}

ParabolaPlant PlantUnder(const Masses& masses) {
  return PlantOf(masses.m2, masses.m3, masses.b2, masses.b3);
}

TEST(ParabolaControls, HoldAConstantSpeed) {
  const Masses masses;
  const Parabola parabola(kWidth / 2, kHeight);
  const double speed = 60.0;
  const double slope = 2 * kHeight / (kWidth / 2);  // at the start
  State x{0, slope * speed / std::hypot(1, slope), 0, speed / std::hypot(1, slope)};
  const Control control = [&](double, const State& at) {
    return ControlsFor(kPrinted, PlantUnder(masses), Of(at), 0.0);
  };
  const double dt = 1e-5;
  const double end = PolygonLength(kWidth / 2, kHeight, kWidth) / speed;
  for (double t = 0; t < end - dt; t += dt) {
    x = Advance(masses, control, t, x, dt);
    ASSERT_NEAR(OffParabola(x), 0.0, 1e-8) << t;
    ASSERT_NEAR(std::hypot(x[1], x[3]), speed, 1e-7) << t;
    // Speeds as above, along for up to 0.1 s.
    ExpectState(x, parabola.At(speed * (t + dt), speed), 1e-7);
  }
  EXPECT_NEAR(x[2], kWidth, 2 * speed * dt);
}

/// From rest to rest by the trapezoid of `speed` and `acceleration`, (45), arc by arc so
/// that no step of the integration straddles a jump.
void FollowTrapezoid(double speed, double acceleration) {
  const Masses masses;
  const Parabola parabola(kWidth / 2, kHeight);
  const double length = PolygonLength(kWidth / 2, kHeight, kWidth);
  const Interpolator along(0.0, parabola.length_mm(), {speed, acceleration});
  const double ramp = speed / acceleration;
  const double tau = length / speed + ramp;  // (51)
  const double ends[] = {0.0, ramp, tau - ramp, tau};
  const double rates[] = {acceleration, 0.0, -acceleration};
  State x{};
  for (int arc = 0; arc < 3; ++arc) {
    const Control control = [&](double, const State& at) {
      return ControlsFor(kPrinted, PlantUnder(masses), Of(at), rates[arc]);
    };
    const int count = 4000;
    const double dt = (ends[arc + 1] - ends[arc]) / count;
    for (int i = 0; i < count && dt > 1e-12; ++i) {
      const double t = ends[arc] + i * dt;
      x = Advance(masses, control, t, x, dt);
      const double at = t + dt;
      const double law = std::min({acceleration * at, speed, acceleration * (tau - at)});
      ASSERT_NEAR(OffParabola(x), 0.0, 1e-7) << at;
      ASSERT_NEAR(std::hypot(x[1], x[3]), std::abs(law), 1e-5) << at;
      const AxisState course = along.At(at);
      ExpectState(x, parabola.At(course.position_mm, course.speed_mm_s), 1e-5);
    }
  }
  // x5(tau) = 2b, x3(tau) = 0, at rest; the speed is known to 1e-5 mm/s.
  EXPECT_NEAR(x[2], kWidth, 1e-5);
  EXPECT_NEAR(x[0], 0.0, 1e-5);
  EXPECT_NEAR(std::hypot(x[1], x[3]), 0.0, 1e-5);
}

TEST(ParabolaControls, FollowTheTrapezoidFromRestToRest) {
  FollowTrapezoid(80.0, 7000.0);
}

TEST(ParabolaControls, FollowTheTimeOptimalTriangle) {
  const double length = PolygonLength(kWidth / 2, kHeight, kWidth);
  const TimeOptimalChoice choice = ChooseTimeOptimal(length, {1000.0, 2000.0});
  ASSERT_LT(choice.speed_mm_s, 1000.0);
  FollowTrapezoid(choice.speed_mm_s, choice.acceleration_mm_s2);
}

TEST(ParabolaControls, SolveThePrintedSystemWhereTheStageMoves) {
  const Masses masses;
  const ParabolaPlant plant = PlantUnder(masses);
  const Parabola parabola(kWidth / 2, kHeight);
  const double k = kPrinted.k_per_mm();
  const double b = kWidth / 2;
  const double acceleration = 3000.0;
  for (int i = 1; i < 20; ++i) {
    const double speed = 4.0 * i;  // = a t
    const ParabolaState x = parabola.At(parabola.length_mm() * i / 20, speed);
    const ParabolaControls u = ControlsFor(kPrinted, plant, x, acceleration);
    const double x4_rate = plant.alpha1_per_s * x.x4_mm_s + plant.beta1_mm_s2_n * u.u4_n;
    const double x6_rate = plant.alpha2_per_s * x.x6_mm_s + plant.beta2_mm_s2_n * u.u6_n;
    // (54) with gamma = a^2 t = a V.
    EXPECT_NEAR(x4_rate + 2 * k * x.x6_mm_s * x.x6_mm_s + 2 * k * (x.x5_mm - b) * x6_rate,
                0.0, 1e-9);
    EXPECT_NEAR(x.x4_mm_s * x4_rate + x.x6_mm_s * x6_rate, acceleration * speed, 1e-7);
  }
}

TEST(ParabolaControls, TheMinimumStillHoldsTheParabola) {
  // So heavy that P is about 1: a light stage is thrown round the apex in microseconds,
  // as J then counts nearly the one force only.
  const Masses masses{400.0, 500.0, 3000.0, 1200.0};
  const double slope = 2 * kHeight / (kWidth / 2);
  State x{0, slope * 50.0, 0, 50.0};
  const Control control = [&](double, const State& at) {
    return MinControlsFor(kPrinted, PlantUnder(masses), Of(at));
  };
  const double dt = 1e-5;
  for (int i = 0; i < 8000; ++i) {
    x = Advance(masses, control, i * dt, x, dt);
    ASSERT_NEAR(OffParabola(x), 0.0, 1e-8) << i;
  }
  EXPECT_GT(x[2], kWidth / 2);  // it passed the apex
}

TEST(ParabolaControls, NoOthersThatHoldTheParabolaAreLess) {
  const ParabolaPlant plant = PlantUnder(Masses{});
  const Parabola parabola(kWidth / 2, kHeight);
  const auto cost = [&](const ParabolaControls& u) {
    const double first = plant.beta1_mm_s2_n * u.u4_n;
    return first * first + u.u6_n * u.u6_n;
  };
  for (int i = 0; i <= 10; ++i) {
    const ParabolaState x = parabola.At(parabola.length_mm() * i / 10, 70.0);
    const double m = parabola.Slope(x.x5_mm);
    const ParabolaControls smallest = MinControlsFor(kPrinted, plant, x);
    for (const double du6 : {-1.0, -1e-3, 1e-3, 1.0}) {
      // (63) is kept when beta1 du4 = m beta2 du6.
      const double du4 = m * plant.beta2_mm_s2_n * du6 / plant.beta1_mm_s2_n;
      EXPECT_GE(cost({smallest.u4_n + du4, smallest.u6_n + du6}),
                cost(smallest) * (1 - 1e-12));
    }
  }
}

TEST(ParabolaControls, AStraightLineNeedsNoForceAcross) {
  const PrintedParabola flat{2.0, 0.0};
  const ParabolaControls u =
      ControlsFor(flat, {-2.0, -3.0, 1.0, 0.5}, {0, 0, 1.0, 10.0}, 100.0);
  EXPECT_EQ(u.u4_n, 0.0);
  EXPECT_NEAR(u.u6_n, (100.0 + 3.0 * 10.0) / 0.5, 1e-12);
}

}  // namespace
}  // namespace intaglio::motion
