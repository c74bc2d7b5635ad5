#include "engrave/optics/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

TEST(Fresnel, CrownGlassReflectsAboutFourPercent) {
  EXPECT_NEAR(ReflectanceAtNormalIncidence(1.5), 0.04, 1e-15);
  EXPECT_EQ(ReflectanceAtNormalIncidence(1), 0);
}

TEST(Fresnel, IsTheLimitOfTheSineAndTangentForms) {
  // Fresnel's own forms: sin^2(a - b) / sin^2(a + b) and tan^2(a - b) / tan^2(a + b);
  // both differ from the limit by about a^2.
  for (const double n : {1.2, 1.5195, 1.9}) {
    const double a = 1e-4;
    const double b = std::asin(std::sin(a) / n);
    const double s = std::pow(std::sin(a - b) / std::sin(a + b), 2);
    const double p = std::pow(std::tan(a - b) / std::tan(a + b), 2);
    EXPECT_NEAR(ReflectanceAtNormalIncidence(n), s, 1e-7);
    EXPECT_NEAR(ReflectanceAtNormalIncidence(n), p, 1e-7);
  }
}

TEST(Fresnel, OutsideTheRangesItThrows) {
  EXPECT_THROW(ReflectanceAtNormalIncidence(0.9), PreconditionError);
}

TEST(Fresnel, GrowsWithTheAngleAndEqualsTheTabulatedValues) {
  const double n = 1.5;
  EXPECT_NEAR(ReflectanceAtAngle(n, 0), ReflectanceAtNormalIncidence(n), 1e-15);
  EXPECT_NEAR(ReflectanceAtAngle(n, std::numbers::pi / 2), 1, 1e-12);
  // At Brewster's angle only the polarization across the plane is reflected, by
  // ((n^2 - 1) / (n^2 + 1))^2 = 0.147929, of which unpolarized light has half.
  EXPECT_NEAR(ReflectanceAtAngle(n, std::atan(n)), 0.0739645, 1e-7);
  double before = 0;
  for (int degree = 0; degree <= 90; ++degree) {
    const double now = ReflectanceAtAngle(n, degree * std::numbers::pi / 180);
    EXPECT_GE(now, before - 1e-15);
    before = now;
  }
  // The marginal ray of NA 0.2 differs little from normal incidence.
  EXPECT_LT(ReflectanceAtAngle(n, std::asin(0.2)) / ReflectanceAtNormalIncidence(n),
            1.01);
}

}  // namespace
}  // namespace intaglio::optics
