#include "materials_db/import_agf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "materials_db/material.h"

namespace intaglio::materials_db {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

// Three glasses as SCHOTT's catalogs of different years have them: Sellmeier with zeros
// behind, Sellmeier without, and the old formula with MD.
constexpr char kCatalog[] =
    "CC SCHOTT catalog, test\r\n"
    "!Standard glass: made all year\r\n"
    "NM N-BK7 2 517642.251 1.5168 64.17 0 1\r\n"
    "GC step 0.5 available\r\n"
    "ED 7.100000 8.300000 2.510000 -0.000900 0\r\n"
    "CD 1.039612120E+00 6.000698670E-03 2.317923440E-01 2.001791440E-02 1.010469450E+00 "
    "1.035606530E+02 0.0 0.0 0.0 0.0\r\n"
    "TD 1.860000E-06 1.310000E-08 -1.370000E-11 4.340000E-07 6.270000E-10 1.7E-01 20\r\n"
    "OD 1.0 1.0 0.0 1.0 2.3 2.3\r\n"
    "LD 3.00000E-01 2.50000E+00\r\n"
    "IT 1.06000E+00 9.99000E-01 1.0E+01\r\n"
    "IT 3.00000E-01 5.00000E-02 2.5E+01\r\n"
    "IT 5.00000E-01 9.98000E-01 1.0E+01\r\n"
    "IT 5.00000E-01 9.94000E-01 2.5E+01\r\n"
    "IT 7.00000E-01 - 2.5E+01\r\n"
    "IT 2.50000E+00\r\n"
    "NM F2 2 620364.360 1.62004 36.37 0 2 4\r\n"
    "ED 8.200000 -1.0 3.599000 0.000200 0\r\n"
    "CD 1.34533359 0.00997743871 0.209073176 0.0470450767 0.937357162 111.886764\r\n"
    "LD 0.32 2.5\r\n"
    "NM BK7 1 517642 1.5168 64.17 0 1\r\n"
    "ED 0 0 - 0 0\r\n"
    "MD 81 0.208 610 0.858 1.114\r\n"
    "CD 2.2718929 -1.0108077E-2 1.0592509E-2 2.0816965E-4 -7.6472538E-6 4.9240991E-7\r\n"
    "LD 0.334 2.325\r\n";

std::vector<std::string> MessagesOf(const Imported& imported) {
  std::vector<std::string> messages;
  for (const Error& error : imported.errors) messages.push_back(error.message);
  return messages;
}

TEST(ImportAgf, ReadsACatalog) {
  const Imported imported = ImportAgf(kCatalog, "SCHOTT");
  ASSERT_THAT(MessagesOf(imported), IsEmpty());
  ASSERT_THAT(imported.materials, SizeIs(3));
  const Material& crown = imported.materials[0];
  EXPECT_EQ(crown.name, "N-BK7");
  EXPECT_EQ(crown.manufacturer, "SCHOTT");
  EXPECT_EQ(crown.source, "AGF catalog SCHOTT: SCHOTT catalog, test\nstep 0.5 available");
  EXPECT_EQ(crown.dispersion.formula, optics::DispersionFormula::kSellmeier1);
  EXPECT_THAT(crown.dispersion.coefficients, SizeIs(6));
  EXPECT_DOUBLE_EQ(*crown.expansion_per_k, 7.1e-6);
  EXPECT_DOUBLE_EQ(*crown.density_kg_m3, 2510);
  // SCHOTT, to five digits.
  EXPECT_NEAR(ComputeOptics(crown, 532, 0.1)->refractive_index, 1.51947, 1e-5);
  EXPECT_NEAR(ComputeOptics(imported.materials[1], 587.5618, 0.1)->refractive_index,
              1.62004, 1e-5);
}

TEST(ImportAgf, KeepsTheInternalTransmittanceByWavelength) {
  const Imported imported = ImportAgf(kCatalog, "SCHOTT");
  ASSERT_THAT(imported.materials, SizeIs(3));
  const Material& crown = imported.materials[0];
  // The longer way counts of the two at 500 nm; what is not measured is left out.
  EXPECT_THAT(crown.transmittance, ElementsAre(optics::Transmittance{0.3, 0.05, 25},
                                               optics::Transmittance{0.5, 0.994, 25},
                                               optics::Transmittance{1.06, 0.999, 10}));
  const double at_500 = -std::log(0.994) / 25, at_1060 = -std::log(0.999) / 10;
  EXPECT_NEAR(*ComputeOptics(crown, 532, 0.1)->absorption_per_mm,
              at_500 + (at_1060 - at_500) * 32 / 560, 1e-15);
  EXPECT_FALSE(ComputeOptics(crown, 1064, 0.1)->absorption_per_mm);
  EXPECT_THAT(imported.materials[1].transmittance, IsEmpty());
  EXPECT_EQ(imported.materials[2].knoop_hardness_hk, 610);
}

TEST(ImportAgf, RefusesATransmittanceThatIsNoShare) {
  std::string catalog = kCatalog;
  catalog.replace(catalog.find("9.98000E-01"), 11, "1.1");
  EXPECT_THAT(MessagesOf(ImportAgf(catalog, "SCHOTT")), IsEmpty());  // the shorter way
  catalog.replace(catalog.find("9.94000E-01"), 11, "99.4");
  EXPECT_THAT(
      MessagesOf(ImportAgf(catalog, "SCHOTT")),
      ElementsAre(HasSubstr("glass N-BK7: transmittance[1] must be 0..1, is 99.4")));
  catalog.replace(catalog.find("99.4"), 4, "much");
  EXPECT_THAT(MessagesOf(ImportAgf(catalog, "SCHOTT")),
              ElementsAre(HasSubstr("line 13: glass N-BK7: IT must be")));
}

TEST(ImportAgf, ReadsMechanicsAndKnowsWhatIsUnknown) {
  const Imported imported = ImportAgf(kCatalog, "SCHOTT");
  ASSERT_THAT(imported.materials, SizeIs(3));
  const Material& old = imported.materials[2];
  EXPECT_EQ(old.dispersion.formula, optics::DispersionFormula::kSchott);
  EXPECT_NEAR(ComputeOptics(old, 587.5618, 0.1)->refractive_index, 1.5168, 1e-5);
  EXPECT_FALSE(old.expansion_per_k);
  EXPECT_FALSE(old.density_kg_m3);
  EXPECT_EQ(old.youngs_modulus_gpa, 81);
  EXPECT_EQ(old.poisson_ratio, 0.208);
  EXPECT_EQ(old.specific_heat_j_kg_k, 858);
  EXPECT_EQ(old.conductivity_w_m_k, 1.114);
}

TEST(ImportAgf, ReadsUtf16) {
  std::string utf16 = "\xFF\xFE";
  for (const char c : std::string_view(kCatalog)) {
    utf16 += c;
    utf16 += '\0';
  }
  EXPECT_EQ(ImportAgf(utf16, "SCHOTT").materials,
            ImportAgf(kCatalog, "SCHOTT").materials);
}

TEST(ImportAgf, ReportsEveryMistakeWithItsLine) {
  const Imported imported = ImportAgf(
      "CD 1 2 3\n"
      "NM A 99 0 1.5\n"
      "CD 1 x\n"
      "NM B 5 0 0\n"
      "CD 1.5 0.01 0.001\n"
      "LD 0.4 0.7\n"
      "NM b 5 0 0\n"
      "NM C 5 0 0\n"
      "NM D 5 0 0\n"
      "CD 1.5 0.01 0.001\n"
      "LD 0.7\n"
      "ED 7 8 2510\n"
      "NM E\n"
      "NM F 5 0 1.7\n"
      "CD 1.5 0.01 0.001\n"
      "LD 0.4 0.7\n"
      "NM G 5 0 0\n"
      "ED 7 8 2510\n"
      "CD 1.5 0.01 0.001\n"
      "LD 0.4 0.7\n",
      "BAD");
  EXPECT_THAT(MessagesOf(imported),
              ElementsAre(StartsWith("line 1: CD occurs before"),
                          StartsWith("line 2: glass A: AGF dispersion formula 99"),
                          StartsWith("line 3: glass A: CD must be numbers"),
                          StartsWith("line 7: glass b is already in line 4"),
                          StartsWith("line 8: glass C: no CD"),
                          StartsWith("line 11: glass D: LD must be"),
                          StartsWith("line 13: glass E: NM needs the formula"),
                          HasSubstr("line 14: glass F: the formula does not give the nd"),
                          HasSubstr("line 17: glass G: density_kg_m3 must be")));
  ASSERT_THAT(imported.materials, SizeIs(1));
  EXPECT_EQ(imported.materials[0].name, "B");
}

TEST(ImportAgf, RefusesWhatIsNoCatalog) {
  EXPECT_THAT(MessagesOf(ImportAgf("", "X")),
              ElementsAre(HasSubstr("contains no glass")));
  EXPECT_THAT(MessagesOf(ImportAgf("\x89PNG\r\n\x1A\n", "X")),
              ElementsAre(HasSubstr("contains no glass")));
  EXPECT_THAT(MessagesOf(ImportAgf(std::string(kMaxAgfBytes + 1, '\n'), "X")),
              ElementsAre(HasSubstr("more than")));
}

TEST(ImportAgf, GivesUpAfterTooManyMistakes) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "CD 1\n";
  const Imported imported = ImportAgf(text, "X");
  EXPECT_THAT(imported.errors, SizeIs(kMaxAgfErrors + 1));
  EXPECT_THAT(imported.errors.back().message, HasSubstr("too many mistakes"));
}

}  // namespace
}  // namespace intaglio::materials_db
