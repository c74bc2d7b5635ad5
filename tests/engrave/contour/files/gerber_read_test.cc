#include "engrave/contour/files/gerber_read.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "engrave/contour/isolation.h"
#include "engrave/contour/union.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A file of mm with six decimals.
std::string Layer(const std::string& commands) {
  return "G04 a layer*\n%FSLAX46Y46*%\n%MOMM*%\n%LPD*%\nG01*\n" + commands + "M02*\n";
}

std::vector<Element> ElementsOf(const std::string& commands) {
  auto elements = ReadGerber(Layer(commands), "a.gbr");
  EXPECT_TRUE(elements) << elements.error().message;
  return elements ? *elements : std::vector<Element>{};
}

/// The area of the copper, as lines and arcs; -1 when it is refused.
double AreaOfLayer(const std::string& commands) {
  const auto united = Unite(ElementsOf(commands));
  EXPECT_TRUE(united) << united.error().message;
  return united ? united->area_mm2 : -1;
}

std::string RefusalOfLayer(const std::string& text, const GerberLimits& limits = {}) {
  const auto elements = ReadGerber(text, "a.gbr", limits);
  return elements ? "no error" : elements.error().message;
}

const char kFlash[] = "D10*\nX5000000Y-2000000D03*\n";

// Two layers that were joined into one file are not the first of them.
TEST(Gerber, RefusesWhatLiesBehindTheEnd) {
  const std::string one = Layer(std::string("%ADD10C,2*%\n") + kFlash);
  EXPECT_THAT(RefusalOfLayer(one + one), ::testing::HasSubstr("more behind the end"));
  EXPECT_THAT(RefusalOfLayer(one + "X0Y0D03*\n"), ::testing::HasSubstr("line 9"));
  for (const std::string& behind :
       {std::string("\r\n\r\n\x1a"), std::string(100, '\0'), std::string("G04 end*\n")})
    EXPECT_EQ(RefusalOfLayer(one + behind), "no error");
}

TEST(Gerber, AByteOrderMarkIsNoCommand) {
  for (const char* begin :
       {"%FSLAX46Y46*%\n%MOMM*%\n", "G04 a layer*\n%FSLAX46Y46*%%MOMM*%"})
    EXPECT_EQ(RefusalOfLayer("\xEF\xBB\xBF" + std::string(begin) + "%ADD10C,2*%\n" +
                             kFlash + "M02*\n"),
              "no error");
}

// Areas by hand; coordinates are rounded to 1 nm.
TEST(Gerber, FlashesStandardApertures) {
  const auto area = [](const std::string& aperture) {
    return AreaOfLayer("%ADD10" + aperture + "*%\n" + kFlash);
  };
  EXPECT_NEAR(area("C,2"), pi, 1e-5);
  EXPECT_NEAR(area("C,2X1"), pi * 0.75, 1e-5);
  EXPECT_NEAR(area("R,3X2"), 6, 1e-5);
  EXPECT_NEAR(area("R,2X2X1"), 4 - pi / 4, 1e-5);
  EXPECT_NEAR(area("O,3X1"), 2 + pi / 4, 1e-5);
  EXPECT_NEAR(area("O,1X3X0.5"), 2 + pi / 4 - pi / 16, 1e-5);
  EXPECT_NEAR(area("P,2X6"), 1.5 * std::sqrt(3), 1e-5);
  EXPECT_NEAR(area("P,2X4X45X0.5"), 2 - pi / 16, 1e-5);
}

TEST(Gerber, PutsFlashesInTheirPlaceInBothUnits) {
  const auto elements = ElementsOf(std::string("%ADD10C,2*%\n") + kFlash);
  ASSERT_EQ(elements.size(), 1U);
  EXPECT_LT((std::get<Circle>(elements[0].shape).center_mm - Vec2(5, -2)).norm(), 1e-9);
  const auto inches = ReadGerber(
      "%FSLAX24Y24*%\n%MOIN*%\n%ADD10C,0.1*%\nD10*\nX5000Y-20000D03*\nM02*\n", "a.gbr");
  ASSERT_TRUE(inches) << inches.error().message;
  const auto& pad = std::get<Circle>((*inches)[0].shape);
  EXPECT_LT((pad.center_mm - 25.4 * Vec2(0.5, -2)).norm(), 1e-9);
  EXPECT_NEAR(pad.diameter_mm, 2.54, 1e-12);
}

TEST(Gerber, DrawsLinesAndArcs) {
  EXPECT_NEAR(AreaOfLayer("%ADD10C,0.5*%\nD10*\nX0Y0D02*\nX4000000D01*\n"), 2 + pi / 16,
              1e-5);
  // A quarter to the left about (0, 0).
  EXPECT_NEAR(AreaOfLayer("%ADD10C,0.5*%\nD10*\nX3000000Y0D02*\nG75*\n"
                          "G03X0Y3000000I-3000000J0D01*\n"),
              pi / 2 * 3 * 0.5 + pi / 16, 1e-5);
  // A rectangle that slides along a slope: its own area, and height by way and width.
  EXPECT_NEAR(AreaOfLayer("%ADD10R,1X2*%\nD10*\nX0Y0D02*\nX3000000Y1000000D01*\n"),
              2 + 3 * 2 + 1 * 1, 1e-5);
}

TEST(Gerber, FillsRegionsAndKeepsTheHolesOfCutIns) {
  EXPECT_NEAR(AreaOfLayer("G36*\nX0Y0D02*\nX4000000D01*\nY3000000D01*\nX0Y0D01*\nG37*\n"),
              6, 1e-5);
  // A square of 4 with a hole of 2 by a cut-in along y = 2.
  EXPECT_NEAR(AreaOfLayer("G36*\nX0Y0D02*\nX4000000D01*\nY4000000D01*\nX0D01*\n"
                          "Y2000000D01*\nX1000000D01*\nY3000000D01*\nX3000000D01*\n"
                          "Y1000000D01*\nX1000000D01*\nY2000000D01*\nX0D01*\nY0D01*\n"
                          "G37*\n"),
              12, 1e-5);
  // Half a disc, and two paths in one region.
  EXPECT_NEAR(AreaOfLayer("G75*\nG36*\nX-2000000Y0D02*\nG01X2000000D01*\n"
                          "G03X-2000000Y0I-2000000J0D01*\nX9000000Y0D02*\n"
                          "G01X10000000D01*\nY1000000D01*\nX9000000D01*\nY0D01*\nG37*\n"),
              2 * pi + 1, 1e-5);
}

TEST(Gerber, ExpandsMacros) {
  const auto area = [](const std::string& macro, const std::string& values) {
    return AreaOfLayer("%AMM1*\n" + macro + "%\n%ADD10M1" + values + "*%\n" + kFlash);
  };
  EXPECT_NEAR(area("0 a comment*1,1,$1,0,0*", ",2"), pi, 1e-5);
  EXPECT_NEAR(area("21,1,$1,$2,1,1,30*", ",3X2"), 6, 1e-5);
  EXPECT_NEAR(area("20,1,0.5,0,0,3,4,0*", ""), 2.5, 1e-5);
  EXPECT_NEAR(area("5,1,6,0,0,2,15*", ""), 1.5 * std::sqrt(3), 1e-5);
  EXPECT_NEAR(area("4,1,3,0,0,4,0,0,3,0,0,45*", ""), 6, 1e-5);
  EXPECT_NEAR(area("$3=$1x0.5*$4=($3+1)/2-0.25*21,1,$3,$4,0,0,0*", ",4"), 2 * 1.25, 1e-5);
  // A rectangle with round corners, as KiCad makes it: two bars and four circles.
  EXPECT_NEAR(area("21,1,3,1,0,0,0*21,1,2,2,0,0,0*1,1,1,1,0.5*1,1,1,-1,0.5*"
                   "1,1,1,-1,-0.5*1,1,1,1,-0.5*",
                   ""),
              6 - 4 * 0.25 + pi / 4, 1e-5);
  // A ring of 3 and 2 cut by a cross of 0.5: numerically, by rings of its four parts.
  double thermal = 0;
  constexpr int kRings = 20000;
  for (int k = 0; k < kRings; ++k) {
    const double r = 1 + 0.5 * (k + 0.5) / kRings;
    thermal += 0.5 / kRings * r * (2 * pi - 8 * std::asin(0.25 / r));
  }
  EXPECT_NEAR(area("7,0,0,3,2,0.5,0*", ""), thermal, 1e-5);
  EXPECT_NEAR(area("7,0,0,3,2,0.5,30*", ""), thermal, 1e-5);
}

TEST(Gerber, RepeatsSteps) {
  const auto elements = ElementsOf(
      "%ADD10C,1*%\n%SRX3Y2I5.0J4.0*%\nD10*\nX0Y0D03*\n"
      "%SR*%\nX100000000Y0D03*\n");
  ASSERT_EQ(elements.size(), 7U);
  EXPECT_EQ(std::get<Circle>(elements[5].shape).center_mm, Vec2(10, 4));
  EXPECT_EQ(std::get<Circle>(elements[6].shape).center_mm, Vec2(100, 0));
}

TEST(Gerber, NamesElementsByPinAndNet) {
  const auto elements = ElementsOf(
      "%ADD10C,1*%\nD10*\n%TO.P,R1,2*%\n%TO.N,GND*%\nX0Y0D03*\n%TD*%\n"
      "%TO.N,VCC*%\nX1100000D03*\n%TD*%\nX9000000D03*\n");
  ASSERT_EQ(elements.size(), 3U);
  EXPECT_EQ(elements[0].name, "R1-2");
  EXPECT_EQ(elements[2].name, "");
  const auto isolation = Isolate(elements, {0.2});
  ASSERT_FALSE(isolation);
  EXPECT_THAT(isolation.error().message,
              HasSubstr("cannot isolate R1-2 from VCC: gap 0.1 "));
}

TEST(Gerber, RefusesWhatItWouldGetWrong) {
  EXPECT_THAT(RefusalOfLayer(Layer("%IPNEG*%\n")),
              AllOf(HasSubstr("a.gbr: line 6:"), HasSubstr("IPNEG")));
  EXPECT_THAT(RefusalOfLayer(Layer("%AMA*1,2,1,0,0*%\n%ADD10A*%\n")),
              HasSubstr("neither 0 nor 1"));
  EXPECT_THAT(RefusalOfLayer(Layer("%LR45*%\n")), HasSubstr("LR45"));
  EXPECT_THAT(RefusalOfLayer(Layer("%A*%\n")), HasSubstr("line 6: A would change"));
  EXPECT_THAT(RefusalOfLayer(Layer("D11*\n")), HasSubstr("D11 is not defined"));
  EXPECT_THAT(RefusalOfLayer(Layer("X1D03*\n")), HasSubstr("no aperture"));
  EXPECT_THAT(RefusalOfLayer(Layer("%ADD10C,-1*%\n")), HasSubstr("diameter"));
  EXPECT_THAT(RefusalOfLayer(Layer("%ADD10X,1*%\n")), HasSubstr("not defined"));
  EXPECT_THAT(RefusalOfLayer(Layer("%ADD10O,1X2*%\nD10*\nX1D01*\n")),
              HasSubstr("a draw with this aperture"));
  EXPECT_THAT(RefusalOfLayer(Layer("G36*\nX0Y0D02*\n")), HasSubstr("does not end"));
  EXPECT_THAT(RefusalOfLayer(Layer("X1.5D02*\n")), HasSubstr("without a point"));
  EXPECT_THAT(RefusalOfLayer("%MOMM*%\nX1D02*\n"), HasSubstr("before the format"));
  EXPECT_THAT(RefusalOfLayer("%FSLAX46Y46*%\n"), HasSubstr("M02"));
  EXPECT_THAT(RefusalOfLayer(""), HasSubstr("M02"));
  EXPECT_THAT(RefusalOfLayer("solid a\n"), HasSubstr("'*'"));
  GerberLimits limits;
  limits.max_elements = 10;
  EXPECT_THAT(
      RefusalOfLayer(Layer("%ADD10C,1*%\n%SRX9999Y9999I1J1*%\nD10*\nX0D03*\n"), limits),
      HasSubstr("more than 10"));
}

}  // namespace
}  // namespace intaglio::contour
