#include "engrave/optics/focus.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

/// Depth at which a ray aimed at `aim_depth_mm` meets the axis, by Snell's law in
/// vectors.
double TracedDepthMm(double aim_depth_mm, double n, double sine_in_air) {
  const double dx = sine_in_air;
  const double dz = -std::sqrt(1 - dx * dx);
  const double start_x = aim_depth_mm * dx / dz;  // on the face, z = 0, left of the axis
  // Snell in vector form, face normal (0, 1), going down: t = d / n + (c / n - c_t) N.
  const double cosine = -dz;
  const double cosine_in_glass = std::sqrt(1 - (1 - cosine * cosine) / (n * n));
  const double tx = dx / n;
  const double tz = dz / n + (cosine / n - cosine_in_glass);
  return -(-start_x / tx) * tz;
}

TEST(Focus, MarginalRaysMeetAtTheDepthAskedFor) {
  for (const double n : {1.0, 1.45, 1.5195, 1.9}) {
    for (const double na : {0.01, 0.1, 0.3, 0.55, 0.95}) {
      for (const double depth_mm : {0.5, 10.0, 80.0}) {
        const double stage_mm = depth_mm * StagePerGlassRatio(n, na);
        EXPECT_NEAR(TracedDepthMm(stage_mm, n, na), depth_mm,
                    1e-11);  // rounding, < 100 mm
      }
    }
  }
}

TEST(Focus, TheStageMovesLessThanTheFocus) {
  EXPECT_LT(StagePerGlassRatio(1.52, 0.2), 1);
  EXPECT_LT(StagePerGlassRatio(1.52, 0.2), 1 / 1.52);
  EXPECT_EQ(StagePerGlassRatio(1, 0.2), 1);
  // The paraxial value is the limit; the difference is about NA^2 (1 - 1 / n^2) / (2 n).
  EXPECT_NEAR(StagePerGlassRatio(1.52, 1e-4), 1 / 1.52, 1e-8);
}

TEST(Focus, ConeIsTheRefractedMarginalRay) {
  for (const double n : {1.0, 1.4607, 1.5195}) {
    for (const double na : {0.05, 0.2, 0.7}) {
      EXPECT_NEAR(ConeTangentInGlass(n, na), std::tan(std::asin(na / n)), 1e-15);
    }
  }
}

TEST(Focus, OutsideTheRangesItThrows) {
  EXPECT_THROW(StagePerGlassRatio(1.5, 0), PreconditionError);
  EXPECT_THROW(StagePerGlassRatio(1.5, 1), PreconditionError);
  EXPECT_THROW(StagePerGlassRatio(0.99, 0.5), PreconditionError);
  EXPECT_THROW(ConeTangentInGlass(1.5, std::nan("")), PreconditionError);
}

TEST(FocusSpread, IsThatOfTwoTracedRays) {
  for (const double n : {1.46, 1.52, 1.8}) {
    for (const double na : {0.05, 0.124, 0.2, 0.6}) {
      const double depth_mm = 40;
      // Snell's law for the marginal ray, from where it meets the face to the axis; and
      // for one near the axis that aims at the same place in air.
      const double in_air = std::asin(na), in_glass = std::asin(na / n);
      const double height_mm = depth_mm * std::tan(in_glass);
      const double aim_mm = height_mm / std::tan(in_air);
      const double small = 1e-5;
      const double near_mm =
          aim_mm * std::tan(small) / std::tan(std::asin(std::sin(small) / n));
      EXPECT_NEAR(FocusSpreadMm(n, na, depth_mm), depth_mm - near_mm, 1e-7);
    }
  }
  EXPECT_EQ(FocusSpreadMm(1.5, 0.2, 0), 0);
  EXPECT_THROW(FocusSpreadMm(1.5, 0.2, -1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::optics
