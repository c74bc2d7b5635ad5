#include "services/job/machine/position_tolerance.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "services/job/machine/machine_axes.h"
#include "services/job/machine/profile_errors.h"

namespace intaglio {

void CheckSteps(const MachineSpec& machine, std::vector<Error>& errors) {
  const double half_um = 1000 * HalfStepsMm(machine).norm();
  if (half_um < kPlannedErrorRatio * machine.position_tolerance_um()) return;
  const Vec3 steps = StepsPerMm(machine);
  std::vector<std::string> fields;
  for (int axis = 0; axis < 3; ++axis)
    if (steps[axis] > 0)
      fields.push_back(fmt::format("{}.steps_per_mm: {:g}", "xyz"[axis], steps[axis]));
  Wrong(errors, "position_tolerance_um",
        fmt::format("{:g} leaves no room for a plan, which keeps within {:g} of it: half "
                    "a step of the axes is {:.4g} um ({}); raise the microsteps of the "
                    "drive and steps_per_mm, or the field",
                    machine.position_tolerance_um(), kPlannedErrorRatio, half_um,
                    fmt::join(fields, ", ")));
}

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
