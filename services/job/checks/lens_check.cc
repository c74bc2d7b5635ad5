#include "services/job/checks/lens_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "services/job/checks/head_check.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/head_clearance.h"

namespace intaglio {

namespace {

void CheckFocus(const JobSpec& job, const MachineLens& lens, const MachineSpec& machine,
                Findings& findings) {
  for (const std::uint32_t channel : job.laser().channels()) {
    const std::string why = WhyFocusIsUnknown(machine, lens.name(), channel);
    if (why.empty()) continue;
    return findings.Wrong("lens.focal_length_mm", lens.focal_length_mm(), "is {}: {}",
                          lens.name(), why);
  }
}

/// A model of this height has its lowest point at least so deep, wherever it is between
/// the margins.
void CheckHeights(const JobSpec& job, const MachineLens& lens, double reach_mm,
                  Findings& findings) {
  const double below_mm = job.block().margin_mm();
  for (int i = 0; i < job.models_size(); ++i) {
    const double height_mm = job.models(i).placement().fit_height_mm();
    if (height_mm + below_mm <= reach_mm || job.block().clip()) continue;
    findings.Wrong(fmt::format("models[{}].placement.fit_height_mm", i), height_mm,
                   "is more than the lens {} reaches: {:.1f} mm below the top face, with "
                   "the margin of {:g} mm; deeper the lens would be in the block; make "
                   "the model lower, or take another lens",
                   lens.name(), reach_mm, below_mm);
  }
}

}  // namespace

void CheckLens(const JobSpec& job, const MachineSpec& machine,
               std::optional<double> stage_per_glass_ratio, Findings& findings) {
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
    CheckFocus(job, *own, machine, findings);
    if (stage_per_glass_ratio)
      CheckHeights(job, *own, ReachMm(*own, *stage_per_glass_ratio), findings);
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
