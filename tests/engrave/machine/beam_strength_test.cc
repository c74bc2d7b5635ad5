#include "engrave/machine/beam_strength.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <tuple>
#include <utility>

namespace intaglio::machine {
namespace {

constexpr double kPerDegree = std::numbers::pi / 180;

/// f100 with its pupil at 140 mm, 532 nm, N-BK7.
BeamStrengthOptions Options(double aperture, double crack_energy_mj) {
  return {{0.532e-3, aperture, 1.519473}, {Vec2(140, 140)}, 49.5, crack_energy_mj, 60};
}

// At 60 mm: what the sums of plane waves of another program leave, at 4 and 10 degrees.
TEST(BeamStrength, LeavesThePublishedIntensity) {
  for (const auto& [aperture, at_4, at_10] :
       {std::tuple{0.03, 0.949, 0.321}, {0.05, 0.677, 0.114}}) {
    const BeamStrength strength(Options(aperture, 0.1));
    for (const auto& [degrees, ratio] : {std::pair{4.0, at_4}, {10.0, at_10}}) {
      const double tangent = std::tan(degrees * kPerDegree);
      EXPECT_NEAR(strength.RatioAt(tangent, 60), ratio, 0.01) << aperture;
      const double radius_mm = strength.UsableRadiusMm(60, 0.1 / ratio);
      const double found = strength.TangentTo(Vec2(radius_mm, 0), 60);
      EXPECT_NEAR(std::atan(found) / kPerDegree, degrees, 0.2) << aperture;
    }
  }
}

// The usable radius by its meaning: within it each place has the energy, whatever the
// direction, and just outside there is one that has not.
TEST(BeamStrength, TheUsableRadiusIsTheLargest) {
  BeamStrengthOptions options = Options(0.03, 0.1);
  options.lens.pupil_mm = {140, 128};
  const BeamStrength strength(options);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double depth_mm = 60 * unit(random), energy_mj = 0.1 + 0.5 * unit(random);
    const double radius_mm = strength.UsableRadiusMm(depth_mm, energy_mj);
    const auto has = [&](double at_mm, double turn) {
      const Vec2 place_mm = at_mm * Vec2(std::cos(turn), std::sin(turn));
      const double tangent = strength.TangentTo(place_mm, depth_mm);
      return energy_mj * strength.RatioAt(tangent, depth_mm) >= 0.1;
    };
    const double turn = 2 * std::numbers::pi * unit(random);
    EXPECT_TRUE(has((1 - 1e-6) * radius_mm * unit(random), turn)) << depth_mm;
    if (radius_mm < 40) {
      EXPECT_FALSE(has(1.0001 * radius_mm, std::numbers::pi / 2)) << depth_mm;
    }
  }
}

TEST(BeamStrength, TooLittleEnergyHasNoRadius) {
  const BeamStrength strength(Options(0.03, 0.1));
  EXPECT_EQ(strength.UsableRadiusMm(30, 0.099), 0);
  EXPECT_GT(strength.UsableRadiusMm(30, 0.101), 0);
}

TEST(BeamStrength, ATelecentricLensHasItsWholeField) {
  BeamStrengthOptions options = Options(0.05, 0.1);
  options.lens = {};
  const BeamStrength strength(options);
  EXPECT_EQ(strength.UsableRadiusMm(60, 0.1), 49.5);
  EXPECT_EQ(strength.DoubleRadiusMm(60), 49.5);
  EXPECT_EQ(strength.RatioAt(strength.TangentTo(Vec2(30, 30), 60), 60), 1);
}

// 2.83 Rayleigh ranges between the foci: 8.8 degrees at 60 mm and NA 0.03.
TEST(BeamStrength, TwoFociBeginAtTheirAngle) {
  const BeamStrength strength(Options(0.03, 0.1));
  EXPECT_NEAR(strength.DoubleRadiusMm(60), 21.6, 0.3);
  EXPECT_FALSE(strength.IsDouble(strength.TangentTo(Vec2(21, 0), 60), 60));
  EXPECT_TRUE(strength.IsDouble(strength.TangentTo(Vec2(22.2, 0), 60), 60));
}

}  // namespace
}  // namespace intaglio::machine
