#include "engrave/optics/crack_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

using std::numbers::pi;

// N-BK7, and the published crack of f = 43 mm at the published 30 mJ.
const MeltingProperties kCrown{2510, 858, 719};
const CrackSize kPublished{0.095, 0.135};
constexpr double kPublishedMj = 30;

TEST(MeltingBound, HoldsTheWholeEnergyInItsVolume) {
  // 2510 kg/m3 * 858 J/(kg K) * 699 K = 1.50535e9 J/m3 = 1505.35 mJ/mm3.
  EXPECT_NEAR(MeltingEnergyMjMm3(kCrown), 1505.35, 0.01);
  for (const double ratio : {1.0, 1.42, 3.0}) {
    const CrackSize bound = MeltingBound(kCrown, kPublishedMj, ratio);
    EXPECT_NEAR(bound.length_mm / bound.diameter_mm, ratio, 1e-12);
    const double volume_mm3 =
        4.0 / 3 * pi * std::pow(bound.diameter_mm / 2, 2) * bound.length_mm / 2;
    EXPECT_NEAR(volume_mm3 * MeltingEnergyMjMm3(kCrown), kPublishedMj, 1e-9);
  }
}

TEST(MeltingBound, IsAboveEveryPublishedCrack) {
  // 200 x 200 x 600 um is the largest of the usual ones, and smaller than the bound.
  for (const CrackSize& crack :
       {kPublished, CrackSize{0.135, 0.195}, CrackSize{.2, .6}}) {
    const CrackSize bound =
        MeltingBound(kCrown, kPublishedMj, crack.length_mm / crack.diameter_mm);
    EXPECT_GT(bound.diameter_mm, crack.diameter_mm);
    EXPECT_LT(HeatedShare(kCrown, crack, kPublishedMj), 1);
  }
  // The share that the header states.
  EXPECT_NEAR(HeatedShare(kCrown, kPublished, kPublishedMj), 0.032, 0.001);
}

TEST(SurfaceEnergy, IsThatOfBothSidesOfAnEllipse) {
  // 2 * 9 J/m2 * pi/4 * 95 um * 135 um = 0.18131 uJ.
  EXPECT_NEAR(SurfaceEnergyMj(kPublished) * 1000, 0.18131, 1e-5);
  EXPECT_NEAR(SurfaceEnergyMj(kPublished, kMaxSurfaceEnergyJM2) /
                  SurfaceEnergyMj(kPublished, kMinSurfaceEnergyJM2),
              10.0 / 8, 1e-12);
}

TEST(CrackOfEnergy, IsTheMeasuredOneAtItsEnergyAndGrowsWithTheCubeRoot) {
  const CrackSize same = CrackOfEnergy(kPublished, kPublishedMj, kPublishedMj);
  EXPECT_DOUBLE_EQ(same.diameter_mm, kPublished.diameter_mm);
  EXPECT_DOUBLE_EQ(same.length_mm, kPublished.length_mm);
  // The heat stays the same share of the pulse at every energy: volume by energy, but for
  // the surface energy, at most a five thousandth of the pulse's.
  for (const double energy_mj : {1.0, 10.0, 60.0}) {
    const CrackSize crack = CrackOfEnergy(kPublished, kPublishedMj, energy_mj);
    EXPECT_NEAR(HeatedShare(kCrown, crack, energy_mj),
                HeatedShare(kCrown, kPublished, kPublishedMj), 1e-5);
    EXPECT_NEAR(crack.length_mm / crack.diameter_mm, 135.0 / 95, 1e-12);
  }
  EXPECT_EQ(CrackOfEnergy(kPublished, kPublishedMj, 1e-4).diameter_mm, 0);
  EXPECT_EQ(CrackOfEnergy(kPublished, kPublishedMj, 0).length_mm, 0);
}

TEST(CrackModel, OutsideTheRangesItThrows) {
  EXPECT_THROW(MeltingEnergyMjMm3({2510, 858, 20}), PreconditionError);
  EXPECT_THROW(MeltingBound(kCrown, 0, 1), PreconditionError);
  EXPECT_THROW(SurfaceEnergyMj({0, 1}), PreconditionError);
  EXPECT_THROW(CrackOfEnergy(kPublished, 1e-5, 1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::optics
