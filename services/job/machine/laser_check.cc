#include "services/job/machine/laser_check.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "services/job/machine/laser_setting.h"

namespace intaglio {
namespace {

// A laser line is far narrower; a profile may give 532 for 532.1.
constexpr double kSameWavelengthNm = 0.5;

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

}  // namespace

void CheckLaserOn(const LaserOptions& laser, const MachineSpec& machine,
                  Findings& findings) {
  const LaserHead& head = machine.laser();
  const auto& rates = head.rates_hz();
  if (std::find(rates.begin(), rates.end(), laser.rate_hz()) == rates.end()) {
    findings.Wrong("laser.rate_hz", laser.rate_hz(), "is none of the rates of {}: {}",
                   machine.name(), fmt::join(rates, " "));
  }
  if (!(std::abs(laser.wavelength_nm() - head.wavelength_nm()) < kSameWavelengthNm)) {
    findings.Wrong("laser.wavelength_nm", laser.wavelength_nm(),
                   "is not the wavelength of {}, {}", machine.name(),
                   head.wavelength_nm());
  }
  if (laser.pulse_energy_mj() > head.pulse_energy_mj()) {
    findings.Wrong("laser.pulse_energy_mj", laser.pulse_energy_mj(),
                   "is above the pulse energy of {}, {}", machine.name(),
                   head.pulse_energy_mj());
  } else if (laser.pulse_energy_mj() < SettableEnergies(machine).min_mj &&
             !EnergiesOf(head)) {
    findings.Wrong("laser.pulse_energy_mj", laser.pulse_energy_mj(),
                   "cannot be set on {}, whose controller switches the laser and no "
                   "more: every pulse has {}; ask for that, or calibrate "
                   "laser.energy_calibration of a controller with a power setting",
                   machine.name(), head.pulse_energy_mj());
  }
  CheckPump(laser, head, findings);
  if (const auto all = EnergiesOf(head); all && (laser.pulse_energy_mj() < all->min_mj ||
                                                 laser.pulse_energy_mj() > all->max_mj)) {
    findings.Wrong("laser.pulse_energy_mj", laser.pulse_energy_mj(),
                   "is outside the calibrated energies of {}, {}..{}", machine.name(),
                   all->min_mj, all->max_mj);
  }
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
