#include "services/job/machine/laser_setting.h"

#include <algorithm>

#include "services/platform/fields/field_defaults.h"

namespace intaglio {

std::optional<EnergyRange> EnergiesOf(const LaserHead& head) {
  const auto& points = head.energy_calibration();
  if (points.empty()) return std::nullopt;
  return EnergyRange{points.begin()->energy_mj(), points.rbegin()->energy_mj()};
}

double MaxPumpEnergy_j(const LaserPump& pump) {
  static const double default_j = DefaultOf<LaserPump>(LaserPump::kMaxEnergyJFieldNumber);
  return pump.has_max_energy_j() ? pump.max_energy_j() : default_j;
}

double MaxPumpPower_w(const LaserPump& pump) {
  static const double default_w = DefaultOf<LaserPump>(LaserPump::kMaxPowerWFieldNumber);
  return pump.has_max_power_w() ? pump.max_power_w() : default_w;
}

EnergyRange SettableEnergies(const MachineSpec& machine) {
  const LaserHead& head = machine.laser();
  if (const auto calibrated = EnergiesOf(head)) return *calibrated;
  const bool takes_frames = machine.laser_line().protocol() != "motion-output" ||
                            machine.motion_line().protocol() == "virtual-cell";
  return {takes_frames ? 0 : head.pulse_energy_mj(), head.pulse_energy_mj()};
}

std::optional<double> LaserSettingFor(const LaserHead& head, double energy_mj) {
  const auto& points = head.energy_calibration();
  if (points.empty()) return std::nullopt;
  const auto above =
      std::find_if(points.begin(), points.end(),
                   [&](const EnergyPoint& p) { return p.energy_mj() >= energy_mj; });
  if (above == points.begin()) return above->setting_ratio();
  if (above == points.end()) return points.rbegin()->setting_ratio();
  const EnergyPoint& below = *(above - 1);
  const double share =
      (energy_mj - below.energy_mj()) / (above->energy_mj() - below.energy_mj());
  return below.setting_ratio() + share * (above->setting_ratio() - below.setting_ratio());
}

}  // namespace intaglio
