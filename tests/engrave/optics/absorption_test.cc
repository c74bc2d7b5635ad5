#include "engrave/optics/absorption.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/optics/fresnel.h"

namespace intaglio::optics {
namespace {

/// Independent: follows one ray's echoes between both faces until nothing is left.
LightShares FollowEchoes(double r, double a_per_mm, double d_mm) {
  LightShares shares{.reflected = r};
  const double t = std::exp(-a_per_mm * d_mm);
  double inside = 1 - r;
  for (int way = 0; way < 2000; ++way) {
    shares.absorbed += inside * (1 - t);
    inside *= t;
    (way % 2 == 0 ? shares.transmitted : shares.reflected) += inside * (1 - r);
    inside *= r;
  }
  return shares;
}

TEST(SharesOfLight, AreThoseOfItsEchoesAndTogetherOne) {
  for (const double r : {0.0, 0.04, 0.5, 0.9}) {
    for (const double a_per_mm : {0.0, 0.0005, 0.1}) {
      for (const double d_mm : {0.0, 6.0, 100.0}) {
        const LightShares got = SharesOfLight(r, a_per_mm, d_mm);
        const LightShares echoes = FollowEchoes(r, a_per_mm, d_mm);
        // Sums of 2000 terms of at most 1.
        EXPECT_NEAR(got.reflected, echoes.reflected, 1e-12);
        EXPECT_NEAR(got.absorbed, echoes.absorbed, 1e-12);
        EXPECT_NEAR(got.transmitted, echoes.transmitted, 1e-12);
        EXPECT_NEAR(got.reflected + got.absorbed + got.transmitted, 1, 1e-15);
      }
    }
  }
}

TEST(SharesOfLight, OfTechnicalGlassAreWithinThePublishedBounds) {
  // Panes of 3 to 6 mm of n = 1.54, whose absorption is 1 % a millimetre.
  const double r = ReflectanceAtNormalIncidence(1.54);
  for (const double d_mm : {3.0, 6.0}) {
    const LightShares shares = SharesOfLight(r, 0.01, d_mm);
    EXPECT_GE(shares.reflected, 0.08);
    EXPECT_LE(shares.reflected, 0.09);
    EXPECT_GE(shares.absorbed, 0.025);
    EXPECT_LE(shares.absorbed, 0.07);
    EXPECT_GE(shares.transmitted, 0.84);
    EXPECT_LE(shares.transmitted, 0.90);
  }
}

TEST(LightAtDepth, FallsWithTheDepthAlone) {
  EXPECT_DOUBLE_EQ(LightAtDepth(0.04, 0.002, 0), 0.96);
  EXPECT_NEAR(LightAtDepth(0.04, 0.002, 100), 0.96 * std::exp(-0.2), 1e-15);
  EXPECT_THROW(LightAtDepth(0.04, -1, 5), PreconditionError);
}

TEST(AbsorptionPerMm, IsThatOfTheCatalogAndLinearBetweenItsEntries) {
  // Ways of different lengths: 0.9 over 10 mm and 0.9^2.5 over 25 mm are the same glass.
  const std::array table = {Transmittance{0.4, 0.0, 10}, Transmittance{0.5, 0.9, 10},
                            Transmittance{0.6, std::pow(0.9, 2.5), 25},
                            Transmittance{0.7, 1.0, 25}};
  const double a = -std::log(0.9) / 10;
  EXPECT_NEAR(AbsorptionPerMm(table, 500).value(), a, 1e-15);
  EXPECT_NEAR(AbsorptionPerMm(table, 532).value(), a, 1e-15);
  EXPECT_NEAR(AbsorptionPerMm(table, 625).value(), 0.75 * a, 1e-15);
  EXPECT_FALSE(AbsorptionPerMm(table, 450));  // opaque at one side
  EXPECT_FALSE(AbsorptionPerMm(table, 399));
  EXPECT_FALSE(AbsorptionPerMm(table, 1064));
  EXPECT_FALSE(AbsorptionPerMm({}, 532));
}

}  // namespace
}  // namespace intaglio::optics
