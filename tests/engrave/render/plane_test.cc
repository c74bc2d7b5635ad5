#include "engrave/render/plane.h"

#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::render {
namespace {

TEST(Plane, BlurKeepsTheSumAndTheMiddle) {
  Plane plane(61, 51, 0.0F);
  plane.at(30, 20) = 1000.0F;
  const int radius = 3;
  const Plane blurred = Blurred(plane, radius);
  double sum = 0.0;
  double spread = 0.0;
  for (int y = 0; y < plane.height; ++y) {
    for (int x = 0; x < plane.width; ++x) {
      sum += blurred.at(x, y);
      spread += blurred.at(x, y) * (x - 30) * (x - 30);
      EXPECT_LE(blurred.at(x, y), blurred.at(30, 20));
      EXPECT_EQ(blurred.at(x, y) > 1e-3F,
                std::abs(x - 30) <= 3 * radius && std::abs(y - 20) <= 3 * radius);
    }
  }
  // Three boxes of 2 r + 1: variance 3 ((2 r + 1)^2 - 1) / 12. Rounding of floats.
  EXPECT_NEAR(sum, 1000.0, 0.01);
  EXPECT_NEAR(spread / sum, 3 * 48 / 12.0, 1e-3);
}

TEST(Plane, EvenLightStaysEvenAwayFromTheBorder) {
  const Plane blurred = Blurred(Plane(40, 40, 2.0F), 4);
  EXPECT_NEAR(blurred.at(20, 20), 2.0F, 1e-5F);
  EXPECT_LT(blurred.at(0, 0), 1.0F);  // outside is dark
}

TEST(Plane, ARadiusWiderThanThePlaneIsNoHarm) {
  const Plane blurred = Blurred(Plane(3, 2, 1.0F), 50);
  for (const float value : blurred.values) EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(Blurred(Plane(3, 2, 1.0F), 0).at(1, 1), 1.0F);
}

}  // namespace
}  // namespace intaglio::render
