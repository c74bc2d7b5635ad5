#include "services/job/checks/reach_check.h"

#include <fmt/format.h>

#include <functional>
#include <string>

#include "services/job/checks/arm_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

std::string SizeText(const Vec3& size_mm) {
  return fmt::format("{:g} x {:g} x {:g}", size_mm.x(), size_mm.y(), size_mm.z());
}

/// `remedy`: what else can be done of an axis that turns.
void CheckAxisTravel(const machine::Axis& axis, int i, const JobSpec& job,
                     const Box3& needed, const MachineSpec& machine,
                     const std::function<std::string()>& remedy, Findings& findings) {
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const double from = needed.min_mm[i], to = needed.max_mm[i];
  if (from >= travel.min_mm[i] && to <= travel.max_mm[i]) return;
  const Vec3 size_mm = BlockSizeOf(job);
  if (axis.unit == machine::AxisUnit::kMm) {
    if (machine.has_head_over_block() && i < 2) {
      return findings.Wrong(
          fmt::format("block.size_mm.{}", axis.name), size_mm[i],
          "does not fit in the field of {}: the mirrors would have to move the beam from "
          "{:.6g} to {:.6g} mm, the field is {} to {}; take a smaller block, a greater "
          "block.margin_mm, or correct block_origin_mm",
          machine.name(), from, to, travel.min_mm[i], travel.max_mm[i]);
    }
    return findings.Wrong(fmt::format("block.size_mm.{}", axis.name), size_mm[i],
                          "does not fit in the travel of {}: the stage would have to "
                          "move from {:.6g} to {:.6g} mm, its travel is {} to {}",
                          machine.name(), from, to, travel.min_mm[i], travel.max_mm[i]);
  }
  findings.Wrong("block.size_mm", SizeText(size_mm),
                 "does not fit in the travel of {}: the axis {} would have to turn from "
                 "{:.6g} to {:.6g} rad, its travel is {} to {}; take a smaller block, or "
                 "move it on the table and correct block_origin_mm{}",
                 machine.name(), axis.name, from, to, travel.min_mm[i], travel.max_mm[i],
                 remedy());
}

void CheckReachFrom(const Vec3& origin_mm, const JobSpec& job, const MachineSpec& machine,
                    std::optional<double> stage_per_glass_ratio, Findings& findings) {
  const Vec3 size_mm = BlockSizeOf(job);
  const Vec3 margin_mm = Vec3::Constant(job.block().margin_mm());
  const optics::MachineFromGlass frame{origin_mm, size_mm,
                                       stage_per_glass_ratio.value_or(1)};
  const machine::AxesFromGlass axes_from_glass(frame, KinematicsOf(machine, job, frame));
  Box3 permitted_mm{margin_mm, size_mm - margin_mm};
  if (!stage_per_glass_ratio) permitted_mm.min_mm.z() = permitted_mm.max_mm.z();
  // The stage that carries the block brings the rest of it under the field, and whether
  // the points of this job are there is checked of each.
  const bool in_tiles = machine.head_over_block().has_block_stage();
  permitted_mm = PartInField(machine, permitted_mm, origin_mm);
  if (in_tiles && (permitted_mm.min_mm.array() > permitted_mm.max_mm.array()).any()) {
    return findings.Wrong("block.size_mm", SizeText(size_mm),
                          "has no part in the field of {}: correct block_place, or "
                          "block_origin_mm of the profile",
                          machine.name());
  }
  const auto remedy = [&]() -> std::string {
    if (!machine.has_polar()) return "";
    Box3 places_mm;
    places_mm.Extend(frame.ToMachine(permitted_mm.min_mm));
    places_mm.Extend(frame.ToMachine(permitted_mm.max_mm));
    return "; " + ArmRemedy(machine, job, places_mm);
  };
  const auto needed =
      machine::AxesOver(axes_from_glass, permitted_mm, AxisLimitsOf(machine).travel_mm);
  if (!needed) {
    return findings.Wrong("block.size_mm", SizeText(size_mm),
                          "is not all within the reach of {}: {}{}", machine.name(),
                          needed.error().message, remedy());
  }
  const auto axes = axes_from_glass.kinematics().axes();
  for (int i = in_tiles ? 2 : 0; i < 3; ++i) {
    CheckAxisTravel(axes[static_cast<std::size_t>(i)], i, job, *needed, machine, remedy,
                    findings);
  }
}

}  // namespace

void CheckReach(const JobSpec& job, const MachineSpec& machine,
                std::optional<double> stage_per_glass_ratio, Findings& findings) {
  if (!OutOfRange(machine.head_over_block(), "").empty()) return;
  if ((machine.has_polar() || machine.has_head_over_block()) &&
      !CheckKinematics(machine).empty())
    return;
  if (!OutOfRange(machine.cartesian(), "").empty()) return;
  Findings found;
  for (const Vec3& origin_mm : BlockOriginsOf(machine, job)) {
    CheckReachFrom(origin_mm, job, machine, stage_per_glass_ratio, found);
  }
  if (job.station() > 1 && !found.found().empty()) {
    return findings.Wrong("station", job.station(), "is beyond the reach of {}: {}",
                          machine.name(), found.found().front().message);
  }
  for (Finding& finding : found.found()) findings.found().push_back(std::move(finding));
}

}  // namespace intaglio
