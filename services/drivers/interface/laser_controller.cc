#include "services/drivers/interface/laser_controller.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::drivers {

Status LaserController::SwitchOutputs(std::uint8_t) {
  return Fail(ErrorCode::kUnsupported,
              "the laser controller has no outputs for other uses: remove outputs of the "
              "machine profile");
}

Status CheckOnePulse(const link::ArmWindow& window) {
  if (window.pulses_per_point <= 1) return {};
  return Fail(ErrorCode::kUnsupported,
              fmt::format("the laser makes a point by one pulse, not by {}",
                          window.pulses_per_point),
              fmt::format("{}", window.pulses_per_point));
}

Status CheckEnergy(const link::LaserIdentity& laser, const link::ArmWindow& window) {
  const double energy_mj = window.pulse_energy_mj;
  const bool fires = std::ranges::find(window.fire, true) != window.fire.end();
  if (!fires || (energy_mj >= laser.min_energy_mj && energy_mj <= laser.max_energy_mj))
    return {};
  return Fail(ErrorCode::kUnsupported,
              fmt::format("the laser makes no pulses of {} mJ but {}..{} mJ", energy_mj,
                          laser.min_energy_mj, laser.max_energy_mj),
              fmt::format("{}", energy_mj));
}

}  // namespace intaglio::drivers
