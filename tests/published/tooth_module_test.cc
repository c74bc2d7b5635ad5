#include "tests/published/tooth_module.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::drive {
namespace {

constexpr double kConstant = 2e-6, kFirst = 0.6e-6;
constexpr Harmonics kPermeance = {kConstant, kFirst, 0, 0, 0};

/// The amplitude of a harmonic of 1 / AtPole1, by the sum over a period.
double ReluctanceHarmonic(const Harmonics& permeance, int n) {
  constexpr int kSteps = 3600;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x0 = 2 * std::numbers::pi * i / kSteps;
    sum += std::cos(n * x0) / AtPole1(permeance, x0);
  }
  return (n == 0 ? 1 : 2) * sum / kSteps;
}

TEST(ToothModule, ThePolesAreHalfAPeriodApart) {
  const Harmonics all = {2, 0.5, 0.2, 0.1, 0.05};
  for (const double x0 : {0.0, 0.4, 2.0, 5.0})
    EXPECT_NEAR(AtPole2(all, x0), AtPole1(all, x0 + std::numbers::pi), 1e-12);
  EXPECT_THROW(AtPole1({1, 2, 0, 0, 0}, std::numbers::pi), PreconditionError);
}

// The largest term that the series leaves out is 5 q^5 / 8, q = 0.3.
TEST(ToothModule, TheSeriesOfTheReluctanceIsThatOfItsHarmonics) {
  const Harmonics series = ReluctanceOf(kConstant, kFirst);
  const double left_out = std::pow(kFirst / kConstant, 5) / kConstant;
  for (int n = 0; n < 5; ++n) {
    EXPECT_NEAR(series[static_cast<std::size_t>(n)], ReluctanceHarmonic(kPermeance, n),
                left_out)
        << n;
  }
  // As printed, the constant has no fourth power, and is that much off.
  const double printed = (1 + 0.3 * 0.3 / 2) / kConstant;
  EXPECT_GT(ReluctanceHarmonic(kPermeance, 0) - printed, left_out);
  // (118) is its first order.
  const Harmonics weak = ReluctanceOf(kConstant, 1e-4 * kConstant);
  EXPECT_NEAR(weak[0] * kConstant, 1, 1e-8);
  EXPECT_NEAR(-weak[1] * kConstant, 1e-4, 1e-11);
}

TEST(ToothModule, FluxesAreThoseOfTheClosedForms) {
  for (const double x0 : {0.0, 0.7, 1.6, 3.0}) {
    // (120).
    const double wave = kFirst * std::cos(x0);
    EXPECT_NEAR(CoilFlux(kPermeance, 100, x0),
                100 / kConstant * (kConstant * kConstant - wave * wave), 1e-16);
    // (121): the magnet sees the same at each place.
    const double magnet_per_h = 3e6;
    const double flux = MagnetFlux(kPermeance, 500, magnet_per_h, x0);
    EXPECT_NEAR(flux, 500 * kConstant / (1 + magnet_per_h * kConstant), 1e-15);
  }
}

// (119), (122): the linear model has the reluctances, and not the permeances, as a
// cosine.
TEST(ToothModule, OfALinearReluctanceTheCoilSeesTheSameAtEachPlace) {
  const double r0 = 5e5, rm = 1e5, magnet_per_h = 3e6;
  for (const double x0 : {0.0, 0.7, 1.6, 3.0}) {
    const double r1 = r0 - rm * std::cos(x0), r2 = r0 + rm * std::cos(x0);
    const Harmonics here = {(1 / r1 + 1 / r2) / 2, (1 / r1 - 1 / r2) / 2, 0, 0, 0};
    // `here` has these permeances at x0 = 0.
    EXPECT_NEAR(CoilFlux(here, 100, 0), 100 / r0, 1e-16);
    const double wave = rm * std::cos(x0);
    EXPECT_NEAR(MagnetFlux(here, 500, magnet_per_h, 0),
                500 / (magnet_per_h + (r0 * r0 - wave * wave) / r0), 1e-16);
  }
}

}  // namespace
}  // namespace intaglio::drive
