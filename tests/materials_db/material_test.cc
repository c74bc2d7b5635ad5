#include "materials_db/material.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/materials_db/test_glasses.h"

namespace intaglio::materials_db {
namespace {

using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

TEST(CheckMaterial, AcceptsASoundGlass) {
  EXPECT_THAT(CheckMaterial(CompleteGlass()), IsEmpty());
  Material bare;
  bare.name = "bare";
  bare.dispersion = CompleteGlass().dispersion;
  EXPECT_THAT(CheckMaterial(bare), IsEmpty());
}

TEST(CheckMaterial, ReportsAllMistakesAtOnce) {
  Material glass;
  glass.manufacturer = "two\nlines";
  glass.source = "\xFF";
  glass.density_kg_m3 = 2.51;  // g/cm3
  glass.expansion_per_k = std::numeric_limits<double>::quiet_NaN();
  const auto errors = CheckMaterial(glass);
  ASSERT_THAT(errors, SizeIs(6));
  EXPECT_THAT(errors[0].message, StartsWith("name"));
  EXPECT_THAT(errors[1].message, StartsWith("manufacturer"));
  EXPECT_THAT(errors[2].message, StartsWith("source"));
  EXPECT_THAT(errors[3].message, StartsWith("dispersion"));
  EXPECT_THAT(errors[4].message, HasSubstr("density_kg_m3 must be 500..20000 kg/m3"));
  EXPECT_EQ(errors[4].value, "2.51");
  EXPECT_THAT(errors[5].message, StartsWith("expansion_per_k"));
}

TEST(CheckMaterial, HoldsEveryPropertyInItsRange) {
  for (const PropertyRow& row : PropertyRows()) {
    Material glass = CompleteGlass();
    for (const double end : {row.min, row.max}) {
      glass.*row.value = end;
      EXPECT_THAT(CheckMaterial(glass), IsEmpty()) << row.name;
    }
    for (const double beyond :
         {std::nextafter(row.min, -1e9), std::nextafter(row.max, 1e9)}) {
      glass.*row.value = beyond;
      EXPECT_THAT(CheckMaterial(glass), SizeIs(1)) << row.name;
    }
  }
}

TEST(CheckMaterial, RefusesAFormulaThatGivesNoIndexInItsRange) {
  Material glass = CompleteGlass();
  glass.dispersion.max_wavelength_um = 10.1;  // the infrared pole is at 10.18 um
  const auto errors = CheckMaterial(glass);
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_THAT(errors[0].message, StartsWith("dispersion"));
}

TEST(CheckMaterial, RefusesNamesNobodyCanType) {
  for (const char* name : {" N-BK7", "N-BK7 ", "N\tBK7", "N\x7f"}) {
    Material glass = CompleteGlass();
    glass.name = name;
    EXPECT_THAT(CheckMaterial(glass), SizeIs(1)) << name;
  }
}

// Against the formulas of the headers in engrave/optics, worked here by hand.
TEST(ComputeOptics, GivesAllValues) {
  const auto values = ComputeOptics(CompleteGlass(), 532, 0.2);
  ASSERT_TRUE(values);
  const double n = values->refractive_index;
  EXPECT_NEAR(n, 1.51947, 1e-5);                   // SCHOTT: n(532 nm) to 5 digits
  EXPECT_NEAR(*values->abbe_number, 64.17, 5e-3);  // SCHOTT: Vd to 2 digits
  EXPECT_NEAR(values->reflectance_ratio, std::pow(0.51947 / 2.51947, 2), 1e-6);
  EXPECT_DOUBLE_EQ(values->stage_per_glass_ratio,
                   std::sqrt(1 - 0.04) / std::sqrt(n * n - 0.04));
  EXPECT_DOUBLE_EQ(values->cone_tangent, 0.2 / std::sqrt(n * n - 0.04));
  EXPECT_DOUBLE_EQ(*values->thermal_strength_k,
                   41.7e6 * (1 - 0.2061) / (7.13e-6 * 82.3e9));
}

TEST(ComputeOptics, ThermalStrengthIsUnknownWhenAValueOfItIs) {
  for (const auto member :
       {&Properties::tensile_strength_mpa, &Properties::poisson_ratio,
        &Properties::expansion_per_k, &Properties::youngs_modulus_gpa}) {
    Material glass = CompleteGlass();
    glass.*member = std::nullopt;
    EXPECT_FALSE(ComputeOptics(glass, 532, 0.1)->thermal_strength_k);
  }
  Material glass = CompleteGlass();
  glass.expansion_per_k = -1e-8;  // withstands any shock, equation (1) does not hold
  EXPECT_FALSE(ComputeOptics(glass, 532, 0.1)->thermal_strength_k);
}

TEST(ComputeOptics, AbbeNumberIsUnknownBeyondTheVisible) {
  Material glass = CompleteGlass();
  glass.dispersion.min_wavelength_um = 0.9;
  const auto values = ComputeOptics(glass, 1064, 0.1);
  ASSERT_TRUE(values);
  EXPECT_FALSE(values->abbe_number);
}

TEST(ComputeOptics, RefusesWhatTheLensOrTheGlassCannot) {
  for (const double na : {0.0, 1.0, -0.1, std::nan("")}) {
    EXPECT_FALSE(ComputeOptics(CompleteGlass(), 532, na));
  }
  const auto outside = ComputeOptics(CompleteGlass(), 10600, 0.1);
  ASSERT_FALSE(outside);
  EXPECT_THAT(outside.error(), Field(&Error::message, StartsWith("glass Test-1: ")));
}

TEST(ComputeOptics, LocalHeatingIsWithstoodThreeTimesAsMuch) {
  const auto values = ComputeOptics(CompleteGlass(), 532, 0.2);
  ASSERT_TRUE(values);
  EXPECT_DOUBLE_EQ(*values->local_thermal_strength_k, 3 * *values->thermal_strength_k);
}

TEST(CheckMaterial, TheTransmittanceAscendsAndIsAShare) {
  Material glass = CompleteGlass();
  std::swap(glass.transmittance[0], glass.transmittance[1]);
  glass.transmittance[2].ratio = -0.1;
  glass.transmittance[2].thickness_mm = 0;
  const std::vector<Error> errors = CheckMaterial(glass);
  ASSERT_EQ(errors.size(), 3U);
  EXPECT_EQ(errors[0].message,
            "transmittance[1] of 0.5 um is not behind that of 0.5461 um; sort the "
            "wavelengths");
  EXPECT_EQ(errors[1].message, "transmittance[2] must be 0..1, is -0.1");
  EXPECT_EQ(errors[2].message, "transmittance[2] must be over 0..1000 mm, is over 0");
}

}  // namespace
}  // namespace intaglio::materials_db
