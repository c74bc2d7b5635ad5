#include "services/job/checks/block_place_check.h"

#include <fmt/format.h>

#include "services/job/machine/block_origin.h"
#include "services/job/machine/profile_errors.h"

namespace intaglio {
namespace {

// Rounding of a place that was computed from the travel.
constexpr double kAllowedStageMm = 1e-6;

void CheckStageAxis(bool present, const AxisLimits& axis, const std::string& path,
                    std::vector<Error>& errors) {
  if (!present)
    return Missing(errors, path, "give the travel and the limits of this axis");
  if (axis.travel_min_mm() <= 0 && axis.travel_max_mm() >= 0 &&
      axis.travel_min_mm() < axis.travel_max_mm())
    return;
  Wrong(errors, path + ".travel_min_mm",
        fmt::format(
            "{} to travel_max_mm, {}, is no travel with 0 in it, where a job without "
            "block_place has the block; give the ends of the travel from there",
            axis.travel_min_mm(), axis.travel_max_mm()));
}

}  // namespace

void CheckBlockStage(const MachineSpec& machine, std::vector<Error>& errors) {
  if (!machine.head_over_block().has_block_stage()) return;
  const BlockStage& stage = machine.head_over_block().block_stage();
  const std::string path = "head_over_block.block_stage.";
  CheckStageAxis(stage.has_x(), stage.x(), path + "x", errors);
  CheckStageAxis(stage.has_y(), stage.y(), path + "y", errors);
}

void CheckBlockPlace(const JobSpec& job, const MachineSpec& machine, Findings& findings) {
  if (!job.has_block_place()) return;
  const Vec2 place_mm = BlockPlaceOf(job);
  if (!machine.head_over_block().has_block_stage()) {
    return findings.Wrong(
        "block_place", fmt::format("{:g}, {:g}", place_mm.x(), place_mm.y()),
        "mm is of a machine with head_over_block.block_stage, and {} has none: choose a "
        "machine with such a stage, or make the jobs again for this one (intaglio "
        "tiles), "
        "and move the block by hand",
        machine.name());
  }
  const BlockStage& stage = machine.head_over_block().block_stage();
  const Vec2 at_mm = BlockStageAt(machine, place_mm);
  const auto check = [&](const char* field, double value_mm, double axis_mm,
                         const AxisLimits& axis) {
    if (axis_mm >= axis.travel_min_mm() - kAllowedStageMm &&
        axis_mm <= axis.travel_max_mm() + kAllowedStageMm)
      return;
    findings.Wrong(
        field, value_mm,
        "is beyond the reach of {}: the stage that carries the block would have "
        "to go to {:.6g} mm, its travel is {} to {}; take a smaller block, or "
        "correct head_over_block.block_stage or block_origin_mm",
        machine.name(), axis_mm, axis.travel_min_mm(), axis.travel_max_mm());
  };
  check("block_place.x_mm", place_mm.x(), at_mm.x(), stage.x());
  check("block_place.y_mm", place_mm.y(), at_mm.y(), stage.y());
}

}  // namespace intaglio
