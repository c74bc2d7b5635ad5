#include "services/job/machine/machine_defaults.h"

#include <algorithm>

#include "engrave/optics/pulse_focus.h"
#include "services/platform/fields/field_defaults.h"

namespace intaglio {
namespace {

/// Gives a beam that fills no lens half of its width over the focal length.
void FillApertures(MachineSpec& machine) {
  const double beam_mm = machine.laser().beam_diameter_mm();
  for (MachineLens& lens : *machine.mutable_lenses()) {
    if (lens.has_numerical_aperture() || beam_mm <= 0 || lens.focal_length_mm() <= 0)
      continue;
    lens.set_numerical_aperture(optics::ApertureOfBeam(beam_mm, lens.focal_length_mm()));
  }
}

}  // namespace

MachineSpec WithMachineDefaults(MachineSpec machine) {
  if (machine.has_mark_line()) {
    FillDefaults(*machine.mutable_mark_line());
    return machine;
  }
  for (SerialLine* line : {machine.mutable_laser_line(), machine.mutable_motion_line()}) {
    FillDefaults(*line);
  }
  if (machine.drive_case() == MachineSpec::DRIVE_NOT_SET)
    FillDefaults(machine, {MachineSpec::kStageLagSFieldNumber});
  if (machine.has_planar_drive()) FillDefaults(*machine.mutable_planar_drive());
  for (AxisDrive& drive : *machine.mutable_axis_drives()) {
    if (drive.has_planar_drive()) FillDefaults(*drive.mutable_planar_drive());
  }
  if (machine.has_laser()) {
    FillDefaults(*machine.mutable_laser(), {LaserHead::kMaxMissedInARowFieldNumber});
  }
  FillApertures(machine);
  return machine;
}

double DefaultRateHz(const LaserHead& head) {
  if (head.has_default_rate_hz()) return head.default_rate_hz();
  const auto highest = std::ranges::max_element(head.rates_hz());
  return highest == head.rates_hz().end() ? 0 : *highest;
}

}  // namespace intaglio
