#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/contour/files/gerber_read.h"
#include "engrave/contour/region/region.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;

std::vector<Element> CopperOf(const std::string& commands) {
  auto elements =
      ReadGerber("%FSLAX46Y46*%\n%MOMM*%\nG01*\nG75*\n" + commands + "M02*\n", "a.gbr");
  EXPECT_TRUE(elements) << elements.error().message;
  return elements ? *elements : std::vector<Element>{};
}

Region RegionOfLayer(const std::string& commands) {
  const auto united = Unite(CopperOf(commands));
  EXPECT_TRUE(united) << united.error().message;
  return united ? RegionOf(*united) : Region{};
}

double AreaOfCopper(const std::string& commands) {
  return AreaOf(RegionOfLayer(commands));
}

const char kApertures[] = "%ADD10R,10X10*%\n%ADD11C,4*%\n%ADD12C,2*%\n%ADD13C,1*%\n";

// Areas by hand; coordinates are rounded to 1 nm.
TEST(GerberPolarity, ClearObjectsTakeAwayWhatWasDrawnBefore) {
  const std::string apertures = kApertures;
  EXPECT_NEAR(AreaOfCopper(apertures + "D10*\nX0Y0D03*\n%LPC*%\nD11*\nX0Y0D03*\n"),
              100 - 4 * pi, 1e-5);
  // Dark again behind it: a disc in the hole.
  EXPECT_NEAR(AreaOfCopper(apertures + "D10*\nX0Y0D03*\n%LPC*%\nD11*\nX0Y0D03*\n%LPD*%\n"
                                       "D12*\nX0Y0D03*\n"),
              100 - 4 * pi + pi, 1e-5);
  // Clear first takes nothing away.
  EXPECT_NEAR(
      AreaOfCopper(apertures + "%LPC*%\nD11*\nX0Y0D03*\n%LPD*%\nD10*\nX0Y0D03*\n"), 100,
      1e-5);
  // A clear line across, and a clear region at a corner.
  EXPECT_NEAR(AreaOfCopper(apertures + "D10*\nX0Y0D03*\n%LPC*%\nD13*\nX-8000000Y0D02*\n"
                                       "X8000000D01*\nG36*\nX3000000Y3000000D02*\n"
                                       "X9000000D01*\nY9000000D01*\nX3000000D01*\n"
                                       "Y3000000D01*\nG37*\n"),
              100 - 10 - 4, 1e-5);
  // A clear flash with a hole leaves a disc.
  EXPECT_NEAR(AreaOfCopper(apertures + "%ADD14C,6X2*%\nD10*\nX0Y0D03*\n%LPC*%\nD14*\n"
                                       "X0Y0D03*\n"),
              100 - 9 * pi + pi, 1e-5);
}

TEST(GerberPolarity, LeavesWhatItDoesNotReach) {
  const auto elements = CopperOf(std::string(kApertures) +
                                 "%TO.N,GND*%\nD10*\nX0Y0D03*\n%TO.N,VCC*%\nD12*\n"
                                 "X20000000Y0D03*\n%TD*%\n%LPC*%\nD13*\nX0Y-9000000D02*\n"
                                 "Y9000000D01*\n");
  ASSERT_EQ(elements.size(), 3U);
  EXPECT_EQ(elements[0].name, "GND");
  EXPECT_EQ(elements[1].name, "GND");
  EXPECT_EQ(elements[2].name, "VCC");
  EXPECT_TRUE(std::holds_alternative<Circle>(elements[2].shape));
}

// Copies follow each other with their dark and clear objects, along y first: the clear
// disc of each copy cuts the copies before it, and the copies behind cover it.
TEST(GerberPolarity, RepeatedBlocksAreDrawnCopyByCopy) {
  const std::string block = "D12*\nX0Y0D03*\n%LPC*%\nD13*\nX1000000Y0D03*\n%LPD*%\n";
  const Region copies =
      RegionOfLayer(std::string(kApertures) + "%SRX3Y1I1.0J0*%\n" + block + "%SR*%\n");
  const auto is_copper = [](double x, double y) {
    bool copper = false;
    for (int copy = 0; copy < 3; ++copy) {
      if (std::hypot(x - copy, y) < 1) copper = true;
      if (std::hypot(x - copy - 1, y) < 0.5) copper = false;
    }
    return copper;
  };
  for (double x = -1.511; x < 4.5; x += 0.0537) {
    for (double y = -1.513; y < 1.5; y += 0.0531)
      EXPECT_EQ(IsInside(copies, {x, y}), is_copper(x, y)) << x << ", " << y;
  }
  // Where nothing overlaps, each copy is alike.
  EXPECT_NEAR(AreaOfCopper(std::string(kApertures) + "%SRX2Y3I20J20*%\n" +
                           "D10*\nX0Y0D03*\n%LPC*%\nD11*\nX0Y0D03*\n%LPD*%\n%SR*%\n"),
              6 * (100 - 4 * pi), 1e-4);
}

TEST(GerberPolarity, MacrosClearWhatTheyDrewThemselves) {
  const std::string macro =
      "%AMT*21,1,4,4,0,0,0*1,0,2,0,0*1,1,1,0,0*%\n%ADD15T*%\n%ADD11C,4*%\n";
  EXPECT_NEAR(AreaOfCopper(macro + "D15*\nX0Y0D03*\n"), 16 - pi + pi / 4, 1e-5);
  // Copper below the hole of a macro stays.
  EXPECT_NEAR(AreaOfCopper(macro + "D11*\nX0Y0D03*\nD15*\nX0Y0D03*\n"), 16, 1e-5);
}

// A ground plane as layout programs draw it: a region, clear pads with thermal bridges.
TEST(GerberPolarity, PlanesWithThermalsAreOneNetWithTheirPads) {
  std::string layer =
      "%ADD10C,3*%\n%ADD11C,2*%\n%ADD12C,0.4*%\nG36*\nX0Y0D02*\n"
      "X30000000D01*\nY20000000D01*\nX0D01*\nY0D01*\nG37*\n%LPC*%\nD10*\n"
      "X6000000Y10000000D03*\nX15000000D03*\nX24000000D03*\n%LPD*%\nD11*\n"
      "X6000000D03*\nX15000000D03*\nX24000000D03*\nD12*\n";
  layer += "X4000000Y10000000D02*\nX8000000D01*\nX6000000Y8000000D02*\nY12000000D01*\n";
  const auto united = Unite(CopperOf(layer));
  ASSERT_TRUE(united) << united.error().message;
  EXPECT_EQ(united->group_count, 3U);  // the plane with one pad, two pads apart
}

}  // namespace
}  // namespace intaglio::contour
