#include "engrave/optics/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

TEST(Fresnel, CrownGlassReflectsAboutFourPercent) {
  EXPECT_NEAR(ReflectanceAtNormalIncidence(1.5), 0.04, 1e-15);
  for (const double n : {1.0, 1.3, 1.5195, 2.4}) {
    EXPECT_NEAR(Reflectance(n, 0), ReflectanceAtNormalIncidence(n), 1e-15);
  }
}

TEST(Fresnel, AgreesWithTheSineAndTangentForms) {
  // Fresnel's own forms: sin^2(a - b) / sin^2(a + b) and tan^2(a - b) / tan^2(a + b).
  for (const double n : {1.2, 1.5195, 1.9}) {
    for (double a = 0.05; a < 1.5; a += 0.05) {
      const double b = std::asin(std::sin(a) / n);
      const double s = std::pow(std::sin(a - b) / std::sin(a + b), 2);
      const double p = std::pow(std::tan(a - b) / std::tan(a + b), 2);
      EXPECT_NEAR(Reflectance(n, a), (s + p) / 2, 1e-13);  // tan grows near pi/2
    }
  }
}

TEST(Fresnel, AtBrewstersAngleHalfOfTheOtherPolarisationIsLeft) {
  const double n = 1.5;
  const double a = std::atan(n);
  // The wave across reflects ((n^2 - 1) / (n^2 + 1))^2, the wave along nothing.
  EXPECT_NEAR(Reflectance(n, a), 0.5 * std::pow(1.25 / 3.25, 2), 1e-15);
}

TEST(Fresnel, GrazingLightIsReflectedWhole) {
  EXPECT_NEAR(Reflectance(1.5, std::numbers::pi / 2), 1, 1e-15);
  EXPECT_EQ(Reflectance(1, std::numbers::pi / 2), 0);
  EXPECT_NEAR(TopFaceTransmittance(1.5, 0), 0.96, 1e-15);
}

TEST(Fresnel, LightIsNeitherLostNorMade) {
  for (const double absorption_per_mm : {0.0, 1e-4, 0.01, 10.0}) {
    for (const double path_mm : {0.0, 5.0, 170.0}) {
      const LightBalance b = LightAtDepth(1.5195, 0.3, absorption_per_mm, path_mm);
      EXPECT_NEAR(b.reflected_ratio + b.absorbed_ratio + b.transmitted_ratio, 1, 1e-15);
      EXPECT_GE(b.absorbed_ratio, 0);
      EXPECT_GE(b.transmitted_ratio, 0);
      EXPECT_NEAR(b.transmitted_ratio,
                  (1 - b.reflected_ratio) * std::exp(-absorption_per_mm * path_mm),
                  1e-15);
    }
  }
}

TEST(Fresnel, OutsideTheRangesItThrows) {
  EXPECT_THROW(ReflectanceAtNormalIncidence(0.9), PreconditionError);
  EXPECT_THROW(Reflectance(1.5, -0.1), PreconditionError);
  EXPECT_THROW(Reflectance(1.5, 1.6), PreconditionError);
  EXPECT_THROW(LightAtDepth(1.5, 0, -1, 1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::optics
