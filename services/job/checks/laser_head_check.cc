#include "services/job/checks/laser_head_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>

#include "services/job/beams/laser_wavelength.h"
#include "services/job/machine/laser_setting.h"
#include "services/job/machine/profile_errors.h"

namespace intaglio {
namespace {

// What a laser controller's identity can list (services/platform/link/laser_protocol.h).
constexpr int kMaxRates = 32;

// proto/machine.proto states both.
constexpr double kQSwitchDelay_us = 5, kQSwitchWidth_us = 120;
constexpr double kMaxQSwitchDelay_us = 20, kMinQSwitchWidth_us = 100;

void CheckRates(const LaserHead& laser, std::vector<Error>& errors) {
  const auto& rates = laser.rates_hz();
  if (rates.empty())
    return Missing(errors, "laser.rates_hz", "give at least one lamp sync rate");
  if (rates.size() > kMaxRates) {
    errors.push_back({ErrorCode::kInvalidValue,
                      fmt::format("laser.rates_hz: {} rates are more than {}",
                                  rates.size(), kMaxRates),
                      fmt::format("{}", rates.size())});
  }
  if (!laser.has_default_rate_hz() ||
      std::ranges::find(rates, laser.default_rate_hz()) != rates.end())
    return;
  Wrong(errors, "laser.default_rate_hz",
        fmt::format("{} is none of laser.rates_hz, {}; give one of them",
                    laser.default_rate_hz(), fmt::join(rates, " ")));
}

void CheckEnergies(const LaserHead& laser, std::vector<Error>& errors) {
  const auto& points = laser.energy_calibration();
  if (points.empty()) return;
  const std::string path = "laser.energy_calibration";
  if (points.size() < 2) {
    return Missing(errors, path + "[1]", "measure the energy at two settings or more");
  }
  for (int i = 1; i < points.size(); ++i) {
    if (points[i].setting_ratio() > points[i - 1].setting_ratio() &&
        points[i].energy_mj() > points[i - 1].energy_mj()) {
      continue;
    }
    Wrong(errors, fmt::format("{}[{}]", path, i),
          fmt::format("setting {} with {} mJ does not exceed setting {} with {} mJ; "
                      "list the measurements by growing setting, and measure those "
                      "again whose energy does not grow",
                      points[i].setting_ratio(), points[i].energy_mj(),
                      points[i - 1].setting_ratio(), points[i - 1].energy_mj()));
  }
  const double min_mj = points.begin()->energy_mj(),
               max_mj = points.rbegin()->energy_mj();
  if (laser.pulse_energy_mj() < min_mj || laser.pulse_energy_mj() > max_mj) {
    Wrong(errors, "laser.pulse_energy_mj",
          fmt::format("{} is outside the calibrated energies, {}..{}",
                      laser.pulse_energy_mj(), min_mj, max_mj));
  }
}

// By the defaults of what is absent: proto/machine.proto.
void CheckTiming(const LaserHead& laser, std::vector<Error>& errors) {
  const PulseTiming& timing = laser.timing();
  const auto or_default = [](bool present, double us, double default_us) {
    return present ? us : default_us;
  };
  const double delay_us = or_default(timing.has_qswitch_delay_us(),
                                     timing.qswitch_delay_us(), kQSwitchDelay_us);
  const double width_us = or_default(timing.has_qswitch_width_us(),
                                     timing.qswitch_width_us(), kQSwitchWidth_us);
  const double max_us = or_default(timing.has_max_qswitch_delay_us(),
                                   timing.max_qswitch_delay_us(), kMaxQSwitchDelay_us);
  const double min_us = or_default(timing.has_min_qswitch_width_us(),
                                   timing.min_qswitch_width_us(), kMinQSwitchWidth_us);
  if (delay_us > max_us) {
    Wrong(errors, "laser.timing.qswitch_delay_us",
          fmt::format("{} is later than the laser takes a trigger, "
                      "max_qswitch_delay_us, {}; reduce it",
                      delay_us, max_us));
  }
  if (width_us < min_us) {
    Wrong(errors, "laser.timing.qswitch_width_us",
          fmt::format("{} is shorter than the laser needs, min_qswitch_width_us, {}; "
                      "increase it",
                      width_us, min_us));
  }
  const auto fastest = std::ranges::max_element(laser.rates_hz());
  if (fastest == laser.rates_hz().end() || delay_us + width_us < 1e6 / *fastest) return;
  Wrong(errors, "laser.timing.qswitch_width_us",
        fmt::format("a trigger of {} us that begins {} us after the lamp sync lasts "
                    "until the next one at {} Hz; reduce it",
                    width_us, delay_us, *fastest));
}

void CheckWavelengths(const LaserHead& laser, std::vector<Error>& errors) {
  constexpr int kMaxFurther = 7;
  const std::string path = "laser.further_wavelengths";
  const auto all_nm = WavelengthsOf(laser);
  if (all_nm.size() == 1) return;
  if (laser.further_wavelengths_size() > kMaxFurther) {
    Wrong(errors, path,
          fmt::format("{} are more than {}; remove what is not used",
                      laser.further_wavelengths_size(), kMaxFurther));
  }
  if (!laser.energy_calibration().empty()) {
    Wrong(errors, path,
          "the calibrated energies, laser.energy_calibration, are those of one "
          "wavelength; give each wavelength a profile of its own");
  }
  for (std::size_t i = 1; i < all_nm.size(); ++i) {
    const auto same = std::find_if(all_nm.begin(), all_nm.begin() + i, [&](double nm) {
      return IsSameWavelength(nm, all_nm[i]);
    });
    if (same == all_nm.begin() + i) continue;
    Wrong(errors, fmt::format("{}[{}].wavelength_nm", path, i - 1),
          fmt::format("{} is given before; remove one of the two", all_nm[i]));
  }
}

void CheckPumpEnergy(const LaserHead& laser, std::vector<Error>& errors) {
  if (!laser.has_pump() || laser.pump().energy_j() <= MaxPumpEnergy_j(laser.pump()))
    return;
  Wrong(errors, "laser.pump.energy_j",
        fmt::format("{} is above max_energy_j, {}; reduce it", laser.pump().energy_j(),
                    MaxPumpEnergy_j(laser.pump())));
}

void CheckFlashHeights(const PulseTiming& timing, std::vector<Error>& errors) {
  if (!timing.has_min_flash_height_mm() || !timing.has_max_flash_height_mm() ||
      timing.min_flash_height_mm() <= timing.max_flash_height_mm())
    return;
  Wrong(errors, "laser.timing.min_flash_height_mm",
        fmt::format("{} is above max_flash_height_mm, {}; exchange them",
                    timing.min_flash_height_mm(), timing.max_flash_height_mm()));
}

}  // namespace

void CheckLaserHead(const LaserHead& laser, std::vector<Error>& errors) {
  CheckRates(laser, errors);
  CheckEnergies(laser, errors);
  CheckWavelengths(laser, errors);
  CheckPumpEnergy(laser, errors);
  CheckFlashHeights(laser.timing(), errors);
  CheckTiming(laser, errors);
}

}  // namespace intaglio
