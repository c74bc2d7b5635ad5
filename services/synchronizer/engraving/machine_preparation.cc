#include "services/synchronizer/engraving/machine_preparation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "services/cell/permission_chain.h"
#include "services/synchronizer/pulses/cell_names.h"

namespace intaglio::synchronizer {
namespace {
constexpr std::chrono::milliseconds kPreparationPeriod{20};  // until it is answered

/// Such a lamp would never be ready; a controller may report no rates.
std::string RateRefusal(const std::vector<double>& rates_hz, double rate_hz) {
  if (rates_hz.empty() || std::ranges::find(rates_hz, rate_hz) != rates_hz.end())
    return "";
  return fmt::format(
      "the laser has no lamp sync rate of {} Hz but {} Hz: cancel the job, correct "
      "laser.rates_hz of the machine profile, and submit the job with one of these rates",
      rate_hz, fmt::join(rates_hz, ", "));
}

/// It would pass by every point.
std::string EnergyRefusal(const link::LaserIdentity& laser, double energy_mj) {
  if (energy_mj >= laser.min_energy_mj && energy_mj <= laser.max_energy_mj) return "";
  const std::string made =
      laser.min_energy_mj == laser.max_energy_mj
          ? fmt::format("{} mJ alone", laser.max_energy_mj)
          : fmt::format("{}..{} mJ", laser.min_energy_mj, laser.max_energy_mj);
  return fmt::format(
      "the laser makes no pulses of {} mJ but {}: cancel the job, correct "
      "laser.pulse_energy_mj of the machine profile, and submit the job with an energy "
      "that the laser has",
      energy_mj, made);
}

}  // namespace

std::string MachinePreparation::Refusal() const {
  if (!job_.block_misfit.empty()) return job_.block_misfit;
  if (!laser_.refusal().empty()) return laser_.refusal();
  if (!laser_.up()) return TextOf(Missing::kLaserLine) + ": " + laser_.message();
  if (const auto can = job_.trigger->CheckLaser(laser_.identity()); !can)
    return can.error().message;
  if (job_.needs_door_lock && !laser_.identity().locks_door) {
    return "the laser controller reports no lock of the door, which the machine profile "
           "has: connect the lock to the controller, or cancel the job, remove "
           "laser.door_lock of the profile and submit the job again";
  }
  for (const double energy_mj : job_.energies.distinct_mj) {
    const std::string energy = EnergyRefusal(laser_.identity(), energy_mj);
    if (!energy.empty()) return energy;
  }
  return RateRefusal(laser_.identity().rates_hz, job_.plan.rate_hz);
}

bool MachinePreparation::MaySend(std::chrono::nanoseconds now) {
  if (now < next_request_ || !laser_.CanSend()) return false;
  next_request_ = now + kPreparationPeriod;
  return true;
}

bool MachinePreparation::LightLamp(std::chrono::nanoseconds now) {
  if (lamp_session_ == laser_.session() && laser_.Has(link::kLampOn)) return true;
  if (MaySend(now) && laser_.Lamp(true, job_.plan.rate_hz))
    lamp_session_ = laser_.session();
  return false;
}

void MachinePreparation::LeaveSafeState(bool may_reset, std::chrono::nanoseconds now) {
  if (laser_.is_latched() && may_reset && MaySend(now)) laser_.SendReset();
}

bool MachinePreparation::LampIsReady() const {
  return laser_.Has(link::kLampWarm) && laser_.status().rate_hz == job_.plan.rate_hz;
}

bool MachinePreparation::NeedsTicks(const MotionView& motion, bool lit) const {
  const bool seen = motion.fresh && !motion.line_down();
  return (lit && !LampIsReady()) || (seen && !motion.at_rest);
}

std::string MachinePreparation::WhatIsMissing(const MotionView& motion, bool lit) const {
  // Without ticks it does not warm up, either.
  if (lit && laser_.Has(link::kNoLampSync)) return TextOf(Missing::kLampSync);
  if (lit && !LampIsReady()) {
    return fmt::format("the lamp warms up: {:.0f} %", 100 * laser_.status().warm_ratio);
  }
  if (!motion.fresh) return TextOf(Missing::kMotionState);
  return motion.line_down() ? motion.message : "";
}

}  // namespace intaglio::synchronizer
