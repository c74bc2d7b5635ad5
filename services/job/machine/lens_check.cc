#include "services/job/machine/lens_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "services/job/job_defaults.h"
#include "services/job/options.h"

namespace intaglio {

void CheckLens(const JobSpec& job, const MachineSpec& machine, Findings& findings) {
  const Lens& lens = job.lens();
  if (const MachineLens* own = FindLens(machine, lens.focal_length_mm())) {
    const double height_mm = job.block().size_mm().z();
    if (own->has_max_block_height_mm() && height_mm > own->max_block_height_mm()) {
      findings.Wrong(
          "block.size_mm.z", height_mm,
          "is above the {} mm of a block under the lens {} of {}; take a lower "
          "block or another lens",
          own->max_block_height_mm(), own->name(), machine.name());
    }
    return;
  }
  std::vector<double> lengths_mm;
  for (const MachineLens& l : machine.lenses()) lengths_mm.push_back(l.focal_length_mm());
  findings.Wrong("lens.focal_length_mm", lens.focal_length_mm(),
                 "is not a lens of {}; it has {}", machine.name(),
                 fmt::join(lengths_mm, " "));
}

void CheckDividedBlock(const JobSpec& job, const MachineSpec& machine,
                       Findings& findings) {
  if (job.laser().channels_size() < 2 || !machine.has_max_divided_block_mm()) return;
  const Vec3 size_mm = Vec3Of(job.block().size_mm());
  const Vec3 max_mm = Vec3Of(machine.max_divided_block_mm());
  for (int axis = 0; axis < 3; ++axis) {
    if (size_mm[axis] <= max_mm[axis]) continue;
    findings.Wrong(
        fmt::format("block.size_mm.{}", "xyz"[axis]), size_mm[axis],
        "is above the {} mm of {} for blocks of several channels; take smaller "
        "blocks, or one channel",
        max_mm[axis], machine.name());
  }
}

}  // namespace intaglio
