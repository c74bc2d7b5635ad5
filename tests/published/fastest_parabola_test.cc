#include "tests/published/fastest_parabola.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "tests/published/parabola_controls.h"

namespace intaglio::motion {
namespace {

TEST(FastestParabola, OnALineWithoutFrictionIsTheTriangle) {
  // (15): 2 sqrt(l / a), a = beta u = 7000 mm/s^2.
  for (const double length_mm : {0.1, 10.0}) {
    const auto fastest = FastestAlongParabola(length_mm / 2, 0, {}, {0, 1000, 7});
    ASSERT_TRUE(fastest.has_value());
    EXPECT_NEAR(fastest->seconds, 2 * std::sqrt(length_mm / 7000),
                1e-6 * fastest->seconds);
  }
}

TEST(FastestParabola, OnALineWithFrictionIsTheBangBangOfTheClosedForm) {
  // v' = beta u - c v up, v' = -beta u - c v down: with a = beta u the speeds are
  // a/c (1 - e^(-ct)) and, back from the end, a/c (e^(ct) - 1); ways and peak are equal.
  const double a = 5000, c = 30, length_mm = 20;
  const auto way_up = [&](double t) { return a / c * (t - (1 - std::exp(-c * t)) / c); };
  const auto way_down = [&](double t) { return a / c * ((std::exp(c * t) - 1) / c - t); };
  double low = 0, high = 1;  // of the time until the switch
  for (int i = 0; i < 200; ++i) {
    const double t = 0.5 * (low + high);
    const double down = std::log(2 - std::exp(-c * t)) / c;
    (way_up(t) + way_down(down) < length_mm ? low : high) = t;
  }
  const double expected = low + std::log(2 - std::exp(-c * low)) / c;
  const auto fastest = FastestAlongParabola(length_mm / 2, 0, {}, {-c, 1000, a / 1000});
  ASSERT_TRUE(fastest.has_value());
  // The switch lies between two of 4000 places.
  EXPECT_NEAR(fastest->seconds, expected, 2e-5 * expected);
}

TEST(FastestParabola, AlwaysUsesOneForceFullyAndNoneBeyond) {
  const double b_mm = 5, h_mm = 2;
  const ForcedAxis lift{-4, 200, 30}, along{-6, 333, 25};
  const auto fastest = FastestAlongParabola(b_mm, h_mm, lift, along, 20000);
  ASSERT_TRUE(fastest.has_value());
  const PrintedParabola parabola{b_mm, h_mm};
  const ParabolaPlant plant{lift.alpha_per_s, along.alpha_per_s, lift.beta_mm_s2_n,
                            along.beta_mm_s2_n};
  int unused = 0;
  for (std::size_t i = 100; i + 100 < fastest->x5_mm_s2.size(); ++i) {
    // In the middle of a step; the published forces by the rate of the speed V.
    const double x5 = 0.5 * (fastest->x5_mm[i] + fastest->x5_mm[i + 1]);
    const double x6 = 0.5 * (fastest->x6_mm_s[i] + fastest->x6_mm_s[i + 1]);
    const double m = parabola.Slope(x5), a = fastest->x5_mm_s2[i];
    const double curved = m * a - 2 * parabola.k_per_mm() * x6 * x6;  // x3''
    const double rate = (a + m * curved) / std::sqrt(1 + m * m);
    const ParabolaControls u = ControlsFor(parabola, plant, {0, m * x6, x5, x6}, rate);
    const double used = std::max(std::abs(u.u4_n) / lift.max_force_n,
                                 std::abs(u.u6_n) / along.max_force_n);
    EXPECT_LE(used, 1.002) << x5;  // steps of 1 / 20000
    if (used < 0.99) ++unused;
  }
  EXPECT_LE(unused, 3) << "but where it switches";
}

TEST(FastestParabola, NoOtherMotionWithinTheForcesIsFaster) {
  // Each force alone makes it slower when it is weaker.
  const auto all = FastestAlongParabola(5, 2, {0, 200, 30}, {0, 333, 25});
  const auto weaker_lift = FastestAlongParabola(5, 2, {0, 200, 27}, {0, 333, 25});
  const auto weaker_along = FastestAlongParabola(5, 2, {0, 200, 30}, {0, 333, 20});
  ASSERT_TRUE(all && weaker_lift && weaker_along);
  EXPECT_LT(all->seconds, weaker_lift->seconds);
  EXPECT_LT(all->seconds, weaker_along->seconds);
  // Half the time takes four times the forces, everywhere.
  const auto four = FastestAlongParabola(5, 2, {0, 200, 120}, {0, 333, 100});
  EXPECT_NEAR(four->seconds, all->seconds / 2, 1e-9 * all->seconds);
}

TEST(FastestParabola, OutsideTheRangesItThrows) {
  EXPECT_THROW((void)FastestAlongParabola(0, 1, {}, {}), PreconditionError);
  EXPECT_THROW((void)FastestAlongParabola(1, -1, {}, {}), PreconditionError);
  EXPECT_THROW((void)FastestAlongParabola(1, 1, {1, 1, 1}, {}), PreconditionError);
  EXPECT_THROW((void)FastestAlongParabola(1, 1, {}, {}, 10), PreconditionError);
}

}  // namespace
}  // namespace intaglio::motion
