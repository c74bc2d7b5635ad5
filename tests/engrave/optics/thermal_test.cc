#include "engrave/optics/thermal.h"

#include <gtest/gtest.h>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

// Window glass: 30 MPa, 0.22, 9e-6 1/K, 70 GPa. 30e6 * 0.78 / (9e-6 * 70e9) = 37.142857
// K.
const ThermalProperties kWindow{30, 0.22, 9e-6, 70};

TEST(Thermal, StrengthOfWindowGlass) {
  EXPECT_NEAR(ThermalStrengthK(kWindow), 37.142857142857, 1e-11);
}

TEST(Thermal, LocalHeatingIsWithstoodThreeTimesAsMuch) {
  EXPECT_NEAR(ThermalStrengthK(kWindow, ThermalLoad::kLocalHeating), 111.428571428571,
              1e-11);
  EXPECT_NEAR(ThermalStrengthK(kWindow, ThermalLoad::kCooling), 55.7142857142857, 1e-11);
}

TEST(Thermal, OutsideTheRangesItThrows) {
  ThermalProperties glass = kWindow;
  glass.expansion_per_k = 0;
  EXPECT_THROW(ThermalStrengthK(glass), PreconditionError);
  glass = kWindow;
  glass.poisson_ratio = 0.6;
  EXPECT_THROW(ThermalStrengthK(glass), PreconditionError);
}

}  // namespace
}  // namespace intaglio::optics
