#include "services/job/quality/quality_options.h"

#include "engrave/optics/crack_size.h"
#include "services/job/job_defaults.h"

namespace intaglio {

proof::QualityOptions QualityOptionsOf(const JobSpec& job, const MachineSpec& machine) {
  proof::QualityOptions options;
  options.min_spacing_mm = job.discretization().min_spacing_mm();
  options.height_ratio = job.discretization().height_ratio();
  if (const MachineLens* lens = FindLens(machine, job.lens().focal_length_mm())) {
    options.crack_diameter_mm = lens->crack_diameter_mm();
    options.crack_length_mm = lens->crack_length_mm();
  }
  // The profile has the cracks of its largest pulse.
  const double full_mj = machine.laser().pulse_energy_mj();
  const double energy_mj = job.laser().pulse_energy_mj();
  if (options.crack_diameter_mm > 0 && options.crack_length_mm > 0 && full_mj > 0 &&
      energy_mj > 0) {
    const optics::CrackSize crack = optics::CrackSizeAt(
        {options.crack_diameter_mm, options.crack_length_mm}, full_mj, energy_mj);
    options.crack_diameter_mm = crack.diameter_mm;
    options.crack_length_mm = crack.length_mm;
  }
  return options;
}

}  // namespace intaglio
