#include "services/job/beams/energy_by_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio {
namespace {

/// Steps of the ladder up to `times` of its beginning.
double StepsTo(double times) {
  // Rounding of the table's numbers is no step.
  constexpr double kRounding = 1e-9;
  return std::ceil(std::log(std::max(1.0, times)) / std::log(kEnergyStepRatio) -
                   kRounding);
}

/// The step of the ladder above `energy_mj` that has `times` of it, at most `largest_mj`.
double StepAbove(double energy_mj, double times, double largest_mj) {
  const double steps = StepsTo(times);
  return std::max(energy_mj,
                  std::min(largest_mj, energy_mj * std::pow(kEnergyStepRatio, steps)));
}

}  // namespace

std::string WhyOneEnergy(const FrozenJob& job) {
  const MachineSpec& machine = job.machine();
  if (!machine.has_head_over_block()) return "no mirrors make its beam oblique";
  if (!machine.head_over_block().has_pupil_x_mm())
    return "its lens is telecentric, and each beam is upright";
  if (!job.job().laser().energy_by_place())
    return "the job does not want it (laser.energy_by_place)";
  const EnergyRange range = SettableEnergies(machine);
  if (range.min_mj < range.max_mj) return "";
  return fmt::format(
      "the driver of the laser of {} cannot vary it (calibrate laser.energy_calibration "
      "if its controller has a power setting)",
      machine.name());
}

std::function<std::uint32_t(const Vec3& glass_mm)> EnergyStepsOf(const FrozenJob& job) {
  if (!job.machine().head_over_block().has_jump_and_dwell() || !WhyOneEnergy(job).empty())
    return {};
  const double max_steps = StepsTo(SettableEnergies(job.machine()).max_mj /
                                   job.job().laser().pulse_energy_mj());
  const auto beams = std::make_shared<const JobBeams>(job);
  return [beams, max_steps](const Vec3& glass_mm) {
    const auto [depth_mm, tangent] = beams->To(glass_mm);
    const double steps = StepsTo(beams->strength().EnergyTimes(tangent, depth_mm));
    return static_cast<std::uint32_t>(std::min(steps, max_steps));
  };
}

PointEnergies RaisedByPlace(const JobBeams& beams, double largest_mj,
                            const PointList& points_mm, const PointEnergies& of_models) {
  std::vector<double> energies_mj;
  energies_mj.reserve(points_mm.size());
  std::set<double> distinct_mj;
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    const auto [depth_mm, tangent] = beams.To(points_mm[i]);
    const double energy_mj =
        StepAbove(of_models.Of(static_cast<std::uint32_t>(i)),
                  beams.strength().EnergyTimes(tangent, depth_mm), largest_mj);
    energies_mj.push_back(energy_mj);
    distinct_mj.insert(energy_mj);
  }
  PointEnergies raised{{distinct_mj.begin(), distinct_mj.end()}, {}};
  if (raised.distinct_mj.size() == 1) return raised;
  raised.of_point.reserve(points_mm.size());
  for (const double energy_mj : energies_mj) {
    const auto found = std::ranges::lower_bound(raised.distinct_mj, energy_mj);
    raised.of_point.push_back(
        static_cast<std::uint32_t>(found - raised.distinct_mj.begin()));
  }
  return raised;
}

Result<PointEnergies> EnergiesOfPoints(const FrozenJob& job, const PointList& points_mm,
                                       std::span<const std::uint32_t> source) {
  auto of_models = INTAGLIO_TRY(EnergiesOfPoints(job.job(), source));
  if (points_mm.empty() || !WhyOneEnergy(job).empty()) return of_models;
  return RaisedByPlace(JobBeams(job), SettableEnergies(job.machine()).max_mj, points_mm,
                       of_models);
}

}  // namespace intaglio
