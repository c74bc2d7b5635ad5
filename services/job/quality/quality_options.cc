#include "services/job/quality/quality_options.h"

#include "engrave/optics/crack_model.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/pulse_energies.h"

namespace intaglio {

proof::QualityOptions QualityOptionsOf(const JobSpec& job, const MachineSpec& machine) {
  proof::QualityOptions options;
  options.min_spacing_mm = job.discretization().min_spacing_mm();
  options.height_ratio = job.discretization().height_ratio();
  if (const MachineLens* lens = FindLens(machine, job.lens().focal_length_mm())) {
    options.crack_diameter_mm = lens->crack_diameter_mm();
    options.crack_length_mm = lens->crack_length_mm();
  }
  // The profile has the cracks of its largest pulse; those of the job's largest one are
  // what breaks the glass.
  const double full_mj = machine.laser().pulse_energy_mj();
  const double energy_mj = DistinctEnergies(job).back();
  const optics::CrackSize full{options.crack_diameter_mm, options.crack_length_mm};
  const bool known = full.diameter_mm > 0 && full.length_mm > 0 && energy_mj > 0;
  if (known && full_mj > optics::SurfaceEnergyMj(full)) {
    const optics::CrackSize crack = optics::CrackOfEnergy(full, full_mj, energy_mj);
    options.crack_diameter_mm = crack.diameter_mm;
    options.crack_length_mm = crack.length_mm;
  }
  return options;
}

}  // namespace intaglio
