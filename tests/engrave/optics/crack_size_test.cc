#include "engrave/optics/crack_size.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

constexpr double kPi = 3.14159265358979;

/// Area of the spheroid by summing its rings.
double SummedSurface(const CrackSize& crack) {
  const double a = crack.diameter_mm / 2, c = crack.length_mm / 2;
  constexpr int kRings = 200000;
  double area = 0;
  for (int i = 0; i < kRings; ++i) {
    const double t = kPi * (i + 0.5) / kRings;
    const double along = std::hypot(a * std::cos(t), c * std::sin(t));
    area += 2 * kPi * a * std::sin(t) * along * kPi / kRings;
  }
  return area;
}

TEST(CrackSize, VolumeFollowsTheEnergy) {
  const CrackSize measured{0.135, 0.195};
  for (const double mj : {0.3, 3.75, 30.0, 60.0}) {
    const CrackSize crack = CrackSizeAt(measured, 30, mj);
    EXPECT_NEAR(CrackVolume_mm3(crack) / CrackVolume_mm3(measured), mj / 30, 1e-12);
    EXPECT_NEAR(crack.length_mm / crack.diameter_mm, 195.0 / 135, 1e-12);
  }
  EXPECT_NEAR(CrackSizeAt(measured, 30, 3.75).length_mm, 0.0975, 1e-12);
  EXPECT_EQ(CrackSizeAt(measured, 30, 30).length_mm, 0.195) << "bit for bit";
}

// rho 2500 kg/m^3, c 800 J/(kg K), from 293.15 to 1693.15 K: 2.8 GJ/m^3. 30 mJ heat
// 0.03 / 2.8e9 m^3 = 0.0107143 mm^3.
TEST(CrackSize, MeltingBoundsThePublishedCracks) {
  const HeatedGlass glass{2500, 800, 1693.15};
  const double bound_mm3 = MeltingBound_mm3(glass, 30);
  EXPECT_NEAR(bound_mm3, 0.0107142857, 1e-9);
  // Trochimczuk 2008, table 10: the lenses of 43 and 70 mm are within it; the largest of
  // chapter 6.1 is not, as the header says.
  EXPECT_LT(CrackVolume_mm3({0.095, 0.135}), bound_mm3);
  EXPECT_LT(CrackVolume_mm3({0.135, 0.195}), bound_mm3);
  EXPECT_GT(CrackVolume_mm3({0.2, 0.6}), bound_mm3);
}

TEST(CrackSize, ItsSurfaceTakesLessThanAThousandthOfThePulse) {
  for (const CrackSize& crack : {CrackSize{0.095, 0.135}, CrackSize{0.2, 0.6},
                                 CrackSize{0.3, 0.1}, CrackSize{0.2, 0.2}}) {
    // The rings' sum is good to 1e-9.
    EXPECT_NEAR(CrackSurface_mm2(crack), SummedSurface(crack), 1e-8);
    const double surface_mj =
        CrackSurface_mm2(crack) * 1e-6 * kMaxSurfaceEnergy_j_m2 * 1e3;
    EXPECT_LT(surface_mj, 0.001 * 30);
  }
}

TEST(CrackSize, OutsideTheRangesItThrows) {
  EXPECT_THROW(CrackSizeAt({0, 1}, 30, 30), PreconditionError);
  EXPECT_THROW(CrackSizeAt({1, 1}, 0, 30), PreconditionError);
  EXPECT_THROW(CrackSizeAt({1, 1}, 30, -1), PreconditionError);
  EXPECT_THROW(CrackSurface_mm2({1, -1}), PreconditionError);
  EXPECT_THROW(MeltingBound_mm3({2500, 800, 293}, 30), PreconditionError);
  EXPECT_THROW(MeltingBound_mm3({2500, 800, 1693}, 0), PreconditionError);
}

}  // namespace
}  // namespace intaglio::optics
