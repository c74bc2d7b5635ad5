#include "services/job/checks/laser_check.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "services/job/beams/laser_wavelength.h"
#include "services/job/head/point_pulses.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio {
namespace {

// Trochimczuk 2008, table 8: E_p f < 1000 W.
void CheckPump(const LaserOptions& laser, const LaserHead& head, Findings& findings) {
  if (!head.has_pump()) return;
  const double power_w = head.pump().energy_j() * laser.rate_hz();
  const double max_w = MaxPumpPower_w(head.pump());
  if (power_w < max_w) return;
  findings.Wrong("laser.rate_hz", laser.rate_hz(),
                 "takes {} W of pump power at {} J a pulse, and laser.pump allows less "
                 "than {} W: choose a rate below {} Hz",
                 power_w, head.pump().energy_j(), max_w, max_w / head.pump().energy_j());
}

/// That the laser of the machine makes pulses of the energy in the field `path`.
void CheckEnergy(const std::string& path, double energy_mj, const MachineSpec& machine,
                 Findings& findings) {
  const LaserHead& head = machine.laser();
  const auto calibrated = EnergiesOf(head);
  if (energy_mj > head.pulse_energy_mj()) {
    findings.Wrong(path, energy_mj, "is above the pulse energy of {}, {}", machine.name(),
                   head.pulse_energy_mj());
  } else if (energy_mj < SettableEnergies(machine).min_mj && !calibrated) {
    findings.Wrong(path, energy_mj,
                   "cannot be set on {}, whose controller switches the laser and no "
                   "more: every pulse has {}; ask for that, or calibrate "
                   "laser.energy_calibration of a controller with a power setting",
                   machine.name(), head.pulse_energy_mj());
  }
  if (calibrated && (energy_mj < calibrated->min_mj || energy_mj > calibrated->max_mj)) {
    findings.Wrong(path, energy_mj, "is outside the calibrated energies of {}, {}..{}",
                   machine.name(), calibrated->min_mj, calibrated->max_mj);
  }
}

}  // namespace

void CheckEnergiesOn(const JobSpec& job, const MachineSpec& machine, Findings& findings) {
  for (int i = 0; i < job.models_size(); ++i) {
    if (!job.models(i).has_pulse_energy_mj()) continue;
    CheckEnergy(fmt::format("models[{}].pulse_energy_mj", i),
                job.models(i).pulse_energy_mj(), machine, findings);
  }
}

void CheckLaserOn(const LaserOptions& laser, const MachineSpec& machine,
                  Findings& findings) {
  const LaserHead& head = machine.laser();
  const auto& rates = head.rates_hz();
  if (std::find(rates.begin(), rates.end(), laser.rate_hz()) == rates.end()) {
    findings.Wrong("laser.rate_hz", laser.rate_hz(), "is none of the rates of {}: {}",
                   machine.name(), fmt::join(rates, " "));
  }
  if (!IsSameWavelength(laser.wavelength_nm(), head.wavelength_nm())) {
    const auto all_nm = WavelengthsOf(head);
    findings.Wrong("laser.wavelength_nm", laser.wavelength_nm(), "is {} of {}, {}",
                   all_nm.size() == 1 ? "not the wavelength" : "none of the wavelengths",
                   machine.name(), fmt::join(all_nm, " "));
  }
  CheckEnergy("laser.pulse_energy_mj", laser.pulse_energy_mj(), machine, findings);
  CheckPump(laser, head, findings);
  if (const std::string what = WhyNotSoManyPulses(machine, laser.pulses_per_point());
      !what.empty())
    findings.Wrong("laser.pulses_per_point", laser.pulses_per_point(), "{}", what);
  std::set<std::uint32_t> seen;
  for (int i = 0; i < laser.channels_size(); ++i) {
    const std::uint32_t channel = laser.channels(i);
    const std::string path = fmt::format("laser.channels[{}]", i);
    if (channel > head.channels()) {
      findings.Wrong(path, channel, "is above the number of channels of {}, {}",
                     machine.name(), head.channels());
    } else if (!seen.insert(channel).second) {
      findings.Wrong(path, channel, "occurs twice");
    }
  }
}

}  // namespace intaglio
