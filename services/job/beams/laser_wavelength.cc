#include "services/job/beams/laser_wavelength.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio {
namespace {

LaserWavelength OwnOf(const LaserHead& head) {
  LaserWavelength own;
  own.set_wavelength_nm(head.wavelength_nm());
  own.set_pulse_energy_mj(head.pulse_energy_mj());
  if (head.has_pulse_duration_ns()) own.set_pulse_duration_ns(head.pulse_duration_ns());
  return own;
}

void SetOwn(const LaserWavelength& chosen, LaserHead& head) {
  head.set_wavelength_nm(chosen.wavelength_nm());
  head.set_pulse_energy_mj(chosen.pulse_energy_mj());
  head.clear_pulse_duration_ns();
  if (chosen.has_pulse_duration_ns())
    head.set_pulse_duration_ns(chosen.pulse_duration_ns());
}

}  // namespace

bool IsSameWavelength(double a_nm, double b_nm) {
  constexpr double kSameNm = 0.5;  // a laser line is far narrower
  return std::abs(a_nm - b_nm) < kSameNm;
}

std::vector<double> WavelengthsOf(const LaserHead& head) {
  std::vector<double> wavelengths_nm = {head.wavelength_nm()};
  for (const LaserWavelength& further : head.further_wavelengths())
    wavelengths_nm.push_back(further.wavelength_nm());
  return wavelengths_nm;
}

MachineSpec ForWavelength(double wavelength_nm, MachineSpec machine) {
  if (machine.laser().further_wavelengths().empty()) return machine;
  LaserHead& head = *machine.mutable_laser();
  auto& further = *head.mutable_further_wavelengths();
  if (!IsSameWavelength(wavelength_nm, head.wavelength_nm())) {
    const auto chosen = std::ranges::find_if(further, [&](const LaserWavelength& one) {
      return IsSameWavelength(wavelength_nm, one.wavelength_nm());
    });
    if (chosen != further.end()) {
      const LaserWavelength own = OwnOf(head);
      SetOwn(*chosen, head);
      *chosen = own;
    }
  }
  std::ranges::sort(further, {}, &LaserWavelength::wavelength_nm);
  return machine;
}

MachineSpec ForWavelengthOf(const LaserOptions& laser, MachineSpec machine) {
  return ForWavelength(
      laser.has_wavelength_nm() ? laser.wavelength_nm() : machine.laser().wavelength_nm(),
      std::move(machine));
}

EnergyRange FullEnergiesOf(const LaserHead& head) {
  EnergyRange range{head.pulse_energy_mj(), head.pulse_energy_mj()};
  for (const LaserWavelength& further : head.further_wavelengths()) {
    range.min_mj = std::min(range.min_mj, further.pulse_energy_mj());
    range.max_mj = std::max(range.max_mj, further.pulse_energy_mj());
  }
  return range;
}

}  // namespace intaglio
