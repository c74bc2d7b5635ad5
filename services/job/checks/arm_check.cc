#include "services/job/checks/arm_check.h"

#include <fmt/format.h>

#include <variant>

#include "services/job/fields/shapes.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/stations.h"

namespace intaglio {

std::optional<machine::ArmLengths> ArmLengthsFor(const MachineSpec& machine,
                                                 const JobSpec& job,
                                                 const Box3& places_mm) {
  auto options = std::get<machine::PolarOptions>(KinematicsOptionsOf(machine));
  options.frame_turn_rad = StationPlaceOf(machine, job).turn_rad;
  return machine::ArmLengthsOver(options, places_mm, AxisLimitsOf(machine).travel_mm);
}

std::string ArmRemedy(const MachineSpec& machine, const JobSpec& job,
                      const Box3& places_mm) {
  const auto lengths = ArmLengthsFor(machine, job, places_mm);
  if (!lengths) return "no length of the arm reaches all of the block there";
  return fmt::format(
      "an arm of {:.6g} to {:.6g} mm reaches all of the block there, polar.arm_length_mm "
      "is {:g}",
      lengths->min_mm, lengths->max_mm, machine.polar().arm_length_mm());
}

std::vector<std::string> ArmNotesOf(const MachineSpec& machine) {
  if (!machine.has_polar()) return {};
  std::vector<std::string> notes;
  const Vec3 corner_mm = Vec3Of(machine.block_origin_mm());
  for (const double side_mm : {50.0, 100.0}) {
    const Box3 places_mm{corner_mm, corner_mm + Vec3(side_mm, side_mm, 0)};
    notes.push_back(fmt::format("block of {0:g} x {0:g} mm at block_origin_mm: {1}",
                                side_mm, ArmRemedy(machine, {}, places_mm)));
  }
  return notes;
}

}  // namespace intaglio
