#include "engrave/optics/pulse_focus.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <tuple>

#include "engrave/optics/focus.h"

namespace intaglio::optics {
namespace {

// Trochimczuk 2008, annex C, table 8: 5 mm, 1 mrad, 12 ns, 30 mJ; lenses of 43 and 70 mm.
TEST(PulseFocus, OfThePublishedLaser) {
  EXPECT_NEAR(ApertureOfBeam(5, 43), std::sin(std::atan(2.5 / 43)), 1.1e-4);
  EXPECT_DOUBLE_EQ(SpotDiameterMm(43, 1), 0.043);
  EXPECT_DOUBLE_EQ(SpotDiameterMm(70, 1), 0.070);
  EXPECT_DOUBLE_EQ(PeakPowerW(30, 12), 2.5e6);
  // 2.5 MW on a circle of 21.5 um radius.
  EXPECT_NEAR(IrradianceWCm2(2.5e6, 0.043),
              2.5e6 / (std::numbers::pi * std::pow(21.5e-4, 2)), 1);
}

// Annex D makes cracks 130 to 140 um long 60 mm deep with f = 43 mm, and 190 to 200 um
// long 100 mm deep with f = 70 mm. The beam of table 8 allows that; one that fills a lens
// of NA 0.2 does not.
TEST(PulseFocus, TheBeamOfTheSourceMakesItsCracksAtItsDepths) {
  constexpr double kIndex = 1.52;
  for (const auto& [focal_mm, depth_mm, crack_mm] :
       std::initializer_list<std::tuple<double, double, double>>{{43, 60, 0.135},
                                                                 {70, 100, 0.195}}) {
    EXPECT_LT(FocusSpreadMm(kIndex, ApertureOfBeam(5, focal_mm), depth_mm), crack_mm);
  }
  EXPECT_GT(FocusSpreadMm(kIndex, 0.2, 60), 4 * 0.135);
}

TEST(PulseFocus, RefusesWhatIsNotPhysical) {
  EXPECT_THROW(ApertureOfBeam(0, 43), std::exception);
  EXPECT_THROW(SpotDiameterMm(43, 0), std::exception);
  EXPECT_THROW(PeakPowerW(30, 0), std::exception);
  EXPECT_THROW(IrradianceWCm2(1, 0), std::exception);
}

}  // namespace
}  // namespace intaglio::optics
