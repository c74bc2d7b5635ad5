#include "services/job/checks/stage_speed_check.h"

#include <fmt/format.h>

#include <array>

#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

struct SpeedField {
  const char* field;
  const char* unit;
};

std::array<SpeedField, 3> SpeedFieldsOf(const MachineSpec& machine) {
  constexpr SpeedField kZ = {"z.max_speed_mm_s", "mm/s"};
  if (machine.has_polar()) {
    return {{{"polar.arm.max_speed_rad_s", "rad/s"},
             {"polar.table.max_speed_rad_s", "rad/s"},
             kZ}};
  }
  return {{{"x.max_speed_mm_s", "mm/s"}, {"y.max_speed_mm_s", "mm/s"}, kZ}};
}

}  // namespace

std::vector<Error> CompareStageSpeed(const MachineSpec& machine,
                                     const Vec3& controller_max) {
  // The controller reports whole nm/s.
  constexpr double kSameSpeed = 1e-6;
  const Vec3 profile_max = AxisLimitsOf(machine).max_speed_mm_s;
  const auto fields = SpeedFieldsOf(machine);
  std::vector<Error> faster;
  for (int i = 0; i < 3; ++i) {
    if (profile_max[i] <= controller_max[i] + kSameSpeed) continue;
    const auto& [field, unit] = fields[static_cast<std::size_t>(i)];
    faster.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("{}: {} {} is faster than the stage controller can step this axis; "
                     "reduce it to at most {} {} in the machine profile",
                     field, profile_max[i], unit, controller_max[i], unit),
         field});
  }
  return faster;
}

}  // namespace intaglio
