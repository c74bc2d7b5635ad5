#include "engrave/io/dxf_unit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

namespace intaglio::io {
namespace {

// Each unit by its legal definition, in metres: the inch of 1959, the US survey foot of
// 1893 (1200 / 3937 m), the astronomical unit of IAU 2012, the light year of a Julian
// year, the parsec as the distance at which that unit is seen at a second of arc.
TEST(DxfUnit, AgreesWithTheDefinitionsOfTheUnits) {
  constexpr double kInch_m = 0.0254, kFoot_m = 12 * kInch_m, kSurveyFoot_m = 1200. / 3937;
  constexpr double kAstronomical_m = 149597870700;
  constexpr double kLightYear_m = 299792458. * 365.25 * 86400;
  constexpr double kParsec_m = 648000 / std::numbers::pi * kAstronomical_m;
  const double units_m[] = {0.001,
                            kInch_m,
                            kFoot_m,
                            5280 * kFoot_m,
                            0.001,
                            0.01,
                            1,
                            1000,
                            1e-6 * kInch_m,
                            1e-3 * kInch_m,
                            3 * kFoot_m,
                            1e-10,
                            1e-9,
                            1e-6,
                            0.1,
                            10,
                            100,
                            1e9,
                            kAstronomical_m,
                            kLightYear_m,
                            kParsec_m,
                            kSurveyFoot_m,
                            kSurveyFoot_m / 12,
                            3 * kSurveyFoot_m,
                            5280 * kSurveyFoot_m};
  ASSERT_EQ(std::size(units_m), 25u);
  for (std::size_t code = 0; code < std::size(units_m); ++code) {
    const auto unit_mm = DxfUnitMm(fmt::format("{}", code));
    ASSERT_TRUE(unit_mm) << code;
    // A few roundings of the products above.
    EXPECT_NEAR(*unit_mm / (1000 * units_m[code]), 1, 1e-15) << code;
  }
}

TEST(DxfUnit, IsAWholeNumberUpTo24WithBlanksAround) {
  EXPECT_EQ(DxfUnitMm("     6\r"), 1000);
  for (const char* text : {"", " ", "25", "-1", "1.5", "1e9", "mm", "nan", "4 4"}) {
    EXPECT_FALSE(DxfUnitMm(text)) << text;
  }
}

}  // namespace
}  // namespace intaglio::io
