#include "services/job/machine/pulse_energies.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/job/fields/of_points.h"

namespace intaglio {

std::vector<double> EnergiesOfModels(const JobSpec& job) {
  const double of_laser = job.laser().pulse_energy_mj();
  std::vector<double> energies_mj;
  for (const Model& model : job.models()) {
    energies_mj.push_back(model.has_pulse_energy_mj() ? model.pulse_energy_mj()
                                                      : of_laser);
  }
  if (energies_mj.empty()) energies_mj.push_back(of_laser);
  return energies_mj;
}

std::vector<double> DistinctEnergies(const JobSpec& job) {
  std::vector<double> energies_mj = EnergiesOfModels(job);
  std::ranges::sort(energies_mj);
  // Not std::ranges::unique: clang 14, which builds the fuzz targets, cannot.
  energies_mj.erase(std::unique(energies_mj.begin(), energies_mj.end()),
                    energies_mj.end());
  return energies_mj;
}

Result<PointEnergies> EnergiesOfPoints(const JobSpec& job,
                                       std::span<const std::uint32_t> source) {
  PointEnergies energies{DistinctEnergies(job), {}};
  if (energies.distinct_mj.size() == 1) return energies;
  std::vector<std::uint32_t> of_models;
  for (const double energy_mj : EnergiesOfModels(job)) {
    const auto found = std::ranges::lower_bound(energies.distinct_mj, energy_mj);
    of_models.push_back(static_cast<std::uint32_t>(found - energies.distinct_mj.begin()));
  }
  auto of_point = INTAGLIO_TRY(OfPoints(of_models, source));
  energies.of_point = std::move(of_point);
  return energies;
}

}  // namespace intaglio
