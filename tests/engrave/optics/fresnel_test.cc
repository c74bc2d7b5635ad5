#include "engrave/optics/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace intaglio::optics
