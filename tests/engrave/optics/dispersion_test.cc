#include "engrave/optics/dispersion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>

#include "tests/test_name.h"

namespace intaglio::optics {
namespace {

using enum DispersionFormula;
using ::testing::HasSubstr;

struct Check {
  const char* name;
  Dispersion glass;
  double wavelength_nm;
  double index;
  double tolerance;  ///< half a unit of the published value's last digit, or as noted
};

void PrintTo(const Check& check, std::ostream* out) {
  *out << check.name << " " << check.wavelength_nm << " nm";
}

const Dispersion kNBk7{
    kSellmeier1,
    {1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653},
    0.3,
    2.5};
const Dispersion kHK9l{
    kRiiSellmeier2,
    {0, 0.614555251, 0.0145987884, 0.656775017, 0.00287769588, 1.02699346, 107.653051},
    0.302,
    2.325};
const Dispersion kFusedSilica{
    kRiiSellmeier,
    {0, 0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161},
    0.21,
    6.7};
const Dispersion kSodaLime{kRiiCauchy, {1.5130, -0.003169, 2, 0.003962, -2}, 0.31, 4.6};
const Dispersion kHK12{kRiiPolynomial,
                       {2.31506425, -0.00827156166, 2, 0.0129535559, -2, 0.000268505199,
                        -4, -5.46028268e-06, -6, 6.24325621e-07, -8},
                       0.365,
                       1.014};

std::string NameOf(const ::testing::TestParamInfo<Check>& info) {
  return test::AsTestName(::testing::PrintToString(info.param));
}

class PublishedIndex : public ::testing::TestWithParam<Check> {};

TEST_P(PublishedIndex, IsReached) {
  const Check& check = GetParam();
  const Result<double> n = RefractiveIndex(check.glass, check.wavelength_nm);
  ASSERT_TRUE(n.has_value()) << n.error().message;
  EXPECT_NEAR(*n, check.index, check.tolerance);
}

// Five published digits: 5e-6, and 1e-9 for the rounding of the comparison.
constexpr double kFiveDigits = 5.001e-6;

INSTANTIATE_TEST_SUITE_P(
    Glasses, PublishedIndex,
    ::testing::Values(Check{"N-BK7", kNBk7, 355, 1.53815, kFiveDigits},
                      Check{"N-BK7", kNBk7, 532, 1.51947, kFiveDigits},
                      Check{"N-BK7", kNBk7, 1064, 1.50663, kFiveDigits},
                      Check{"H-K9L", kHK9l, 355, 1.53818, kFiveDigits},
                      Check{"H-K9L", kHK9l, 532, 1.51947, kFiveDigits},
                      Check{"H-K9L", kHK9l, 1064, 1.50669, kFiveDigits},
                      Check{"fused silica", kFusedSilica, 355, 1.47607, kFiveDigits},
                      Check{"fused silica", kFusedSilica, 532, 1.46071, kFiveDigits},
                      Check{"fused silica", kFusedSilica, 1064, 1.44963, kFiveDigits},
                      // nd of the maker's catalog, six digits.
                      Check{"H-K12", kHK12, 587.5618, 1.533589, 5.1e-7}),
    NameOf);

// Formulas whose records come without a published index: the equation worked out by hand
// at l = 2 um with round coefficients, so that every term counts and the powers of two
// are exact.
INSTANTIATE_TEST_SUITE_P(
    ByHand, PublishedIndex,
    ::testing::Values(
        Check{"schott",
              {kSchott, {2, 0.125, 1, 2, 4, 8}, 1, 3},
              2000,
              std::sqrt(2 + 0.5 + 1 / 4. + 2 / 16. + 4 / 64. + 8 / 256.),
              1e-15},
        Check{"herzberger",
              {kHerzberger, {1.5, 0.1, 0.2, 0.01, 0.001, 0.0001}, 1, 3},
              2000,
              1.5 + 0.1 / 3.972 + 0.2 / (3.972 * 3.972) + 0.04 + 0.016 + 0.0064,
              1e-15},
        Check{"sellmeier_2",
              {kSellmeier2, {0.5, 0.75, 1, 3, 0.5}, 1, 3},
              2000,
              std::sqrt(1 + 0.5 + 0.75 * 4 / 3 + 3 / 3.75),
              1e-15},
        Check{"conrady",
              {kConrady, {1.5, 0.25, 0.5}, 1, 3},
              2000,
              1.5 + 0.125 + 0.5 / (8 * std::sqrt(2.)),
              1e-15},
        Check{"sellmeier_3",
              {kSellmeier3, {0.25, 1, 0.5, 2, 0.75, 3, 1, 20}, 1, 3},
              2000,
              std::sqrt(1 + 1 / 3. + 2 / 2. + 3 / 1. - 4 / 16.),
              1e-15},
        Check{"handbook_1",
              {kHandbook1, {3, 0.5, 2, 0.125}, 1, 3},
              2000,
              std::sqrt(3 + 0.25 - 0.5),
              1e-15},
        Check{"handbook_2",
              {kHandbook2, {3, 0.5, 2, 0.125}, 1, 3},
              2000,
              std::sqrt(3 + 1 - 0.5),
              1e-15},
        Check{"sellmeier_4",
              {kSellmeier4, {1.5, 0.5, 2, 0.25, 3}, 1, 3},
              2000,
              std::sqrt(1.5 + 1 + 1),
              1e-15},
        Check{"extended",
              {kExtended, {2, 0.125, 1, 2, 4, 8, 16, 32}, 1, 3},
              2000,
              std::sqrt(2.96875 + 16 / 1024. + 32 / 4096.),
              1e-15},
        Check{"sellmeier_5",
              {kSellmeier5, {0.25, 1, 0.5, 2, 0.75, 3, 1, 20, 0.5, 8}, 1, 3},
              2000,
              std::sqrt(1 + 1 / 3. + 1 + 3 - 0.25 - 0.5),
              1e-15},
        Check{"extended_2",
              {kExtended2, {2, 0.125, 1, 2, 4, 8, 0.0625, 0.015625}, 1, 3},
              2000,
              std::sqrt(2.96875 + 1 + 1),
              1e-15},
        Check{"extended_3",
              {kExtended3, {2, 0.125, 0.0625, 1, 2, 4, 8, 16, 32}, 1, 3},
              2000,
              std::sqrt(2 + 0.5 + 1 + 0.25 + 0.125 + 0.0625 + 0.03125 + 0.015625 +
                        1 / 128.),
              1e-15},
        // c3^c4 = 0.5^2 and 3^1; then 0.5 l^1.
        Check{"rii 4",
              {kRiiMixed, {1.5, 0.9375, 2, 0.5, 2, 0.5, 0, 3, 1, 0.5, 1}, 1, 3},
              2000,
              std::sqrt(1.5 + 1 + 0.5 + 1),
              1e-15},
        Check{"rii 7, 5 coefficients",
              {kRiiHerzberger, {3.4, 0.1, -0.1, 1e-3, -1e-4}, 1, 3},
              2000,
              3.4 + 0.1 / 3.972 - 0.1 / (3.972 * 3.972) + 0.004 - 0.0016,
              1e-15},
        Check{
            "rii 6", {kRiiGases, {0.125, 0.5, 2.25, 1, 4.25}, 1, 3}, 2000, 1.625, 1e-15},
        // r = 0.25 + 0.5 - 0.25 = 0.5, n^2 = 2 / 0.5.
        Check{"rii 8", {kRiiRetro, {0.25, 0.25, 2, -0.0625}, 1, 3}, 2000, 2, 1e-15},
        // shift = 0.5: 2 * 0.5 / (0.25 + 0.25) = 2.
        Check{"rii 9", {kRiiExotic, {1.5, 1, 2, 2, 1.5, 0.25}, 1, 3}, 2000, 2, 1e-15}),
    NameOf);

TEST(Dispersion, FamiliesAgreeOnTheSameGlass) {
  // N-BK7 as refractiveindex.info formulas 2 and 1, whose resonances are b and b^2;
  // 1e-14: the sums are rounded in another order.
  Dispersion rii2 = kNBk7;
  rii2.formula = kRiiSellmeier2;
  rii2.coefficients.insert(rii2.coefficients.begin(), 0);
  Dispersion rii1 = rii2;
  rii1.formula = kRiiSellmeier;
  for (std::size_t i = 2; i < 7; i += 2) {
    rii1.coefficients[i] = std::sqrt(rii1.coefficients[i]);
  }
  for (double nm = 300; nm <= 2500; nm += 50) {
    EXPECT_NEAR(*RefractiveIndex(rii2, nm), *RefractiveIndex(kNBk7, nm), 1e-14);
    EXPECT_NEAR(*RefractiveIndex(rii1, nm), *RefractiveIndex(kNBk7, nm), 1e-14);
  }
}

TEST(Dispersion, AbbeNumbersAreTheCatalogs) {
  EXPECT_NEAR(*AbbeNumber(kNBk7), 64.17, 0.005);
  EXPECT_NEAR(*AbbeNumber(kHK9l), 64.198732, 1e-4);  // lines rounded to 0.1 pm
  EXPECT_NEAR(*AbbeNumber(kHK12), 55.469983, 1e-4);
  EXPECT_FALSE(AbbeNumber({kRiiCauchy, {1.5}, 0.3, 1}).has_value());
}

// Schott, optical glass data sheets: N-BK7 517642.251.
TEST(Dispersion, TotalAndPartialDispersionAreTheCatalogs) {
  EXPECT_NEAR(*TotalDispersion(kNBk7), 0.008054, 5e-7);
  EXPECT_NEAR(*PartialDispersionRatio(kNBk7, 435.8343, 486.1327), 0.5349, 5e-5);
  EXPECT_NEAR(*PartialDispersionRatio(kNBk7, 486.1327, 656.2725), 1, 1e-12);
  EXPECT_FALSE(TotalDispersion({kRiiCauchy, {1.5}, 0.3, 1}).has_value());
  EXPECT_FALSE(PartialDispersionRatio(kNBk7, 200, 486.1327).has_value());
}

TEST(Dispersion, OutsideTheRangeTheRangeIsNamed) {
  for (const double nm :
       {299.9, 2500.1, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    const auto n = RefractiveIndex(kNBk7, nm);
    ASSERT_FALSE(n.has_value());
    EXPECT_EQ(n.error().code, ErrorCode::kInvalidValue);
    EXPECT_THAT(n.error().message, HasSubstr("300..2500 nm"));
  }
  EXPECT_TRUE(RefractiveIndex(kNBk7, 300).has_value());
  EXPECT_TRUE(RefractiveIndex(kNBk7, 2500).has_value());
}

TEST(Dispersion, WrongCountsAreRefusedAndPaddingIsNot) {
  Dispersion glass = kNBk7;
  glass.coefficients.pop_back();
  const auto n = RefractiveIndex(glass, 532);
  ASSERT_FALSE(n.has_value());
  EXPECT_THAT(n.error().message, HasSubstr("sellmeier_1 takes 6 coefficients, not 5"));

  glass = kNBk7;
  glass.coefficients.resize(10, 0.0);
  EXPECT_EQ(*RefractiveIndex(glass, 532), *RefractiveIndex(kNBk7, 532));
  glass.coefficients[8] = 0.1;
  EXPECT_FALSE(RefractiveIndex(glass, 532).has_value());

  EXPECT_FALSE(RefractiveIndex({kRiiCauchy, {1.5, 0.1}, 0.3, 1}, 532).has_value());
  EXPECT_FALSE(RefractiveIndex({kRiiCauchy, {}, 0.3, 1}, 532).has_value());
}

TEST(Dispersion, SenselessResultsAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(RefractiveIndex({kRiiCauchy, {nan}, 0.3, 1}, 532).has_value());
  EXPECT_FALSE(RefractiveIndex({kRiiCauchy, {0.9}, 0.3, 1}, 532).has_value());
  EXPECT_FALSE(RefractiveIndex({kRiiPolynomial, {-2}, 0.3, 1}, 532).has_value());
  // On the pole of a Sellmeier term.
  EXPECT_FALSE(RefractiveIndex({kRiiSellmeier, {0, 1, 0.5}, 0.3, 1}, 500).has_value());
  EXPECT_FALSE(RefractiveIndex({kRiiCauchy, {1.5}, 1, 0.3}, 532).has_value());
  EXPECT_FALSE(RefractiveIndex({kRiiCauchy, {1.5}, 0, 1}, 532).has_value());
}

TEST(Dispersion, NamesAndNumbersLeadBack) {
  std::set<std::string> names;
  const auto expect_round_trip = [&](Result<DispersionFormula> formula) {
    ASSERT_TRUE(formula.has_value());
    const std::string name = DispersionFormulaName(*formula);
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_EQ(*DispersionFormulaFromName(name), *formula);
  };
  for (int number = 1; number <= 13; ++number) {
    expect_round_trip(DispersionFormulaFromAgf(number));
  }
  for (int number = 1; number <= 9; ++number) {
    expect_round_trip(DispersionFormulaFromRii(number));
    EXPECT_EQ(DispersionFormulaName(*DispersionFormulaFromRii(number)),
              "rii_formula_" + std::to_string(number));
  }
  EXPECT_EQ(*DispersionFormulaFromAgf(2), kSellmeier1);
  EXPECT_EQ(*DispersionFormulaFromAgf(13), kExtended3);
  EXPECT_FALSE(DispersionFormulaFromAgf(0).has_value());
  EXPECT_FALSE(DispersionFormulaFromAgf(14).has_value());
  EXPECT_FALSE(DispersionFormulaFromRii(10).has_value());
  EXPECT_THAT(DispersionFormulaFromName("selmeier").error().message,
              HasSubstr("sellmeier_1"));
}

TEST(Dispersion, MeasuredRecordsReachTheirCatalogIndex) {
  const std::filesystem::path root = INTAGLIO_SOURCE_DIR "/tests/data/glass";
  int checked = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    if (entry.path().extension() != ".yml") continue;
    std::ifstream file(entry.path());
    Dispersion glass;
    double nd = 0;
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "-") {
        std::string formula;
        int number = 0;
        if (words >> word >> formula >> number && formula == "formula" &&
            glass.coefficients.empty()) {
          glass.formula = *DispersionFormulaFromRii(number);
        }
      } else if (word == "wavelength_range:") {
        words >> glass.min_wavelength_um >> glass.max_wavelength_um;
      } else if (word == "coefficients:" && glass.coefficients.empty()) {
        for (double c = 0; words >> c;) glass.coefficients.push_back(c);
      } else if (word == "nd:") {
        words >> nd;
      }
    }
    const auto n = RefractiveIndex(glass, 587.5618);
    ASSERT_TRUE(n.has_value()) << entry.path() << n.error().message;
    if (nd == 0) continue;
    EXPECT_NEAR(*n, nd, kFiveDigits) << entry.path();
    ++checked;
  }
  EXPECT_GE(checked, 5);
}

}  // namespace
}  // namespace intaglio::optics
