#include "engrave/optics/oblique_intensity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "engrave/optics/oblique_focus.h"

namespace intaglio::optics {
namespace {

constexpr double kPerDegree = std::numbers::pi / 180;
const FocusedBeam kNarrow{0.532e-3, 0.03, 1.519473}, kWide{0.532e-3, 0.05, 1.519473};
const FocusedBeam kNarrowUv{0.355e-3, 0.03, 1.538155}, kWideUv{0.355e-3, 0.05, 1.538155};

TEST(ObliqueIntensity, RayleighRangeIsThePublishedOne) {
  EXPECT_NEAR(RayleighRangeMm(kNarrow), 0.286, 5e-4);
  EXPECT_NEAR(RayleighRangeMm(kWide), 0.103, 5e-4);
  EXPECT_NEAR(RayleighRangeMm(kNarrowUv), 0.193, 5e-4);
  EXPECT_NEAR(RayleighRangeMm(kWideUv), 0.070, 5e-4);
}

// Sums of 181 x 181 plane waves on a square grid, by a program of its own, sampled every
// 0.3 um across and so much less than its peak: 0.003 of it are lost at most.
TEST(ObliqueIntensity, PeakIsThatOfTheIndependentSum) {
  struct {
    FocusedBeam beam;
    double depth_mm, ratios[6];
  } const rows[] = {{kNarrow, 30, {.998, .986, .940, .835, .662, .323}},
                    {kNarrow, 60, {.994, .949, .793, .532, .321, .159}},
                    {kNarrow, 100, {.985, .864, .568, .304, .190, .095}},
                    {kWide, 5, {.998, .994, .985, .958, .905, .702}},
                    {kWide, 30, {.981, .876, .645, .406, .231, .116}},
                    {kWide, 60, {.929, .677, .386, .181, .114, .058}},
                    {kWide, 100, {.835, .517, .227, .111, .070, .035}},
                    {kNarrowUv, 60, {.987, .889, .615, .343, .210, .105}},
                    {kWideUv, 60, {.860, .548, .253, .123, .077, .039}}};
  const double degrees[] = {2, 4, 6, 8, 10, 14};
  for (const auto& row : rows) {
    for (int i = 0; i < 6; ++i) {
      const double ratio =
          ObliquePeakRatio(row.beam, std::tan(degrees[i] * kPerDegree), row.depth_mm);
      EXPECT_NEAR(ratio, row.ratios[i], 0.0035)
          << row.beam.numerical_aperture << " " << row.depth_mm << " " << degrees[i];
    }
  }
}

TEST(ObliqueIntensity, UprightBeamsAndAirLoseNothing) {
  EXPECT_EQ(ObliquePeakRatio(kWide, 0, 60), 1);
  EXPECT_EQ(ObliquePeakRatio(kWide, 0.2, 0), 1);
  EXPECT_EQ(ObliquePeakRatio({0.532e-3, 0.05, 1}, 0.2, 60), 1);
}

TEST(ObliqueIntensity, TheTableFollowsTheSum) {
  const ObliqueLoss loss(kWide, 80, 0.36);
  for (const double degree : {0.7, 1.9, 3.3, 5.1, 7.7, 11.3, 17.0}) {
    for (const double depth_mm : {3.0, 11.0, 27.0, 44.0, 71.0}) {
      const double tangent = std::tan(degree * kPerDegree);
      const double ratio = ObliquePeakRatio(kWide, tangent, depth_mm);
      EXPECT_NEAR(loss.RatioAt(tangent, depth_mm), ratio, 0.01)
          << degree << " " << depth_mm;
    }
  }
  EXPECT_EQ(loss.RatioAt(0, 40), 1);
  EXPECT_EQ(loss.RatioAt(0.1, 0), 1);
}

// Between the nodes of the table, of lenses and wavelengths that there are.
TEST(ObliqueIntensity, TheTableKeepsItsBound) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const FocusedBeam& beam : {kNarrow, kWide, kNarrowUv, kWideUv}) {
    const ObliqueLoss loss(beam, 80, 0.36);
    for (int i = 0; i < 40; ++i) {
      const double tangent = 0.36 * unit(random), depth_mm = 80 * unit(random);
      const double excess = 1 / ObliquePeakRatio(beam, tangent, depth_mm) - 1;
      if (excess < 0.01) continue;
      EXPECT_NEAR((1 / loss.RatioAt(tangent, depth_mm) - 1) / excess, 1,
                  ObliqueLoss::kMaxExcessError)
          << beam.numerical_aperture << " " << tangent << " " << depth_mm;
    }
  }
}

TEST(ObliqueIntensity, TheLargestTangentKeepsTheRatio) {
  const ObliqueLoss loss(kNarrow, 60, 0.36);
  const double tangent = loss.MaxTangent(60, 0.8);
  EXPECT_NEAR(loss.RatioAt(tangent, 60), 0.8, 1e-6);
  // D = Rayleigh range: 5.3 degrees by the thin pencil; the sum is a little kinder.
  EXPECT_NEAR(std::atan(tangent) / kPerDegree, 5.7, 0.5);
  EXPECT_EQ(loss.MaxTangent(0.01, 0.8), 0.36);
}

// 1 / (1 + (D / 2 z)^2) against 1 / sqrt(1 + (D / z)^2).
TEST(ObliqueIntensity, TwoFociAreStrongWhereTheyAreFarApart) {
  const double range_mm = RayleighRangeMm(kWide);
  EXPECT_FALSE(HasTwoStrongFoci(kWide, 2.82 * range_mm));
  EXPECT_TRUE(HasTwoStrongFoci(kWide, 2.84 * range_mm));
}

}  // namespace
}  // namespace intaglio::optics
