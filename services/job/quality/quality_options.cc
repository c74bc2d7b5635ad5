#include "services/job/quality/quality_options.h"

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
  return options;
}

}  // namespace intaglio
