#include "services/job/machine/position_tolerance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace intaglio {

std::string ToleranceMismatch(double controller_um, double profile_um) {
  constexpr double kSameRatio = 0.01;
  if (controller_um <= 0 || profile_um <= 0) return {};
  const double difference_um = std::abs(controller_um - profile_um);
  if (difference_um <= kSameRatio * std::max(controller_um, profile_um)) return {};
  return fmt::format(
      "the position tolerance of the stage controller is {:g} um and that of the profile "
      "{:g} um: {}; set position_tolerance_um of the profile and the tolerance of the "
      "controller to the same value",
      controller_um, profile_um,
      controller_um < profile_um
          ? "pulses between the two are held back, and the job may hardly make progress"
          : "points may lie farther from their place than the profile allows");
}

}  // namespace intaglio
