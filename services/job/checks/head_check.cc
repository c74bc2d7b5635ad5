#include "services/job/checks/head_check.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/machine/clearance.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/head_clearance.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/profile_errors.h"

namespace intaglio {
namespace {

constexpr int kMaxFixtures = 64;

const MachineLens* ZeroLensOf(const MachineSpec& machine) {
  return machine.zero_lens().empty() ? &machine.lenses(0)
                                     : FindLensNamed(machine, machine.zero_lens());
}

void CheckFixtures(const MachineSpec& machine, std::vector<Error>& errors) {
  if (machine.fixtures_size() > kMaxFixtures) {
    Wrong(errors, "fixtures",
          fmt::format("{} of them are more than {}", machine.fixtures_size(),
                      kMaxFixtures));
  }
  for (int i = 0; i < machine.fixtures_size(); ++i) {
    const Fixture& fixture = machine.fixtures(i);
    const std::string path = fmt::format("fixtures[{}]", i);
    if (fixture.name().empty()) Missing(errors, path + ".name", "give it a name");
    const Vec3 min_mm = Vec3Of(fixture.min_mm()), max_mm = Vec3Of(fixture.max_mm());
    for (int axis = 0; axis < 3; ++axis) {
      if (min_mm[axis] < max_mm[axis]) continue;
      Wrong(errors, fmt::format("{}.min_mm.{}", path, "xyz"[axis]),
            fmt::format("{} is not below max_mm, {}", min_mm[axis], max_mm[axis]));
    }
  }
}

/// At the lower end of the travel of z, over what the block stands on. Jobs keep their
/// points in the block; motion by hand goes there.
void AddBelowTable(const MachineSpec& machine, std::vector<Error>& warnings) {
  const auto kinematics = KinematicsOf(machine);
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const double lowest_mm = std::min(kinematics->ToPlace(travel.min_mm).z(),
                                    kinematics->ToPlace(travel.max_mm).z());
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (int i = 0; i < machine.lenses_size(); ++i) {
    const MachineLens& lens = machine.lenses(i);
    const Vec3 corner_mm = BlockOriginOf(machine, 1, lens.name());
    const Box3 table{Vec3::Constant(-kInfinite),
                     Vec3(kInfinite, kInfinite, corner_mm.z())};
    const machine::Clearance clearance({{FreeDistanceMm(lens)}}, {table});
    const auto collision = clearance.At(Vec3(0, 0, lowest_mm));
    if (!collision) continue;
    Wrong(warnings, "z.travel",
          fmt::format("brings the focus of the lens {0} to {1:.6g} mm and its lowest "
                      "edge, {2:g} mm above it, {3:.1f} mm into the table, which is at "
                      "{4:.6g} mm, where the block stands; shorten the travel of z by "
                      "{3:.1f} mm, or correct block_origin_mm.z or lenses[{5}]",
                      lens.name(), lowest_mm, FreeDistanceMm(lens), collision->overlap_mm,
                      corner_mm.z(), i));
  }
}

}  // namespace

void CheckHead(const MachineSpec& machine, std::vector<Error>& errors) {
  CheckFixtures(machine, errors);
  for (int i = 0; i < machine.lenses_size(); ++i) {
    const MachineLens& lens = machine.lenses(i);
    if (!lens.has_free_distance_mm() || !lens.has_working_distance_mm()) continue;
    if (!machine.has_head_body() || lens.free_distance_mm() <= lens.working_distance_mm())
      continue;
    Wrong(errors, fmt::format("lenses[{}].free_distance_mm", i),
          fmt::format("{} is above working_distance_mm, {}: the lens would end above the "
                      "reference face of the head; measure both again",
                      lens.free_distance_mm(), lens.working_distance_mm()));
  }
}

std::string WhyFocusIsUnknown(const MachineSpec& machine, const std::string& name,
                              std::uint32_t channel) {
  const MachineLens* lens = FindLensNamed(machine, name);
  const MachineLens* zero = ZeroLensOf(machine);
  if (lens == nullptr || zero == nullptr || lens->name() == zero->name()) return "";
  if (FindZero(machine, channel, name) != nullptr) return "";
  if (lens->has_working_distance_mm() && zero->has_working_distance_mm()) return "";
  return fmt::format(
      "the zero of {} was measured with the lens {}, and how far the focus of {} lies "
      "from it is not known: teach its zero (intaglio teach zero --lens {} --channel "
      "{}), "
      "or give working_distance_mm of both lenses",
      machine.name(), zero->name(), name, name, channel);
}

std::vector<Error> LensWarningsOf(const MachineSpec& machine) {
  std::vector<Error> warnings;
  if (machine.has_mark_line()) return warnings;
  for (int i = 0; i < machine.lenses_size(); ++i) {
    const std::string why = WhyFocusIsUnknown(machine, machine.lenses(i).name(), 1);
    if (why.empty()) continue;
    const std::string path = fmt::format("lenses[{}].working_distance_mm", i);
    warnings.push_back({ErrorCode::kMissing,
                        fmt::format("{}: jobs for the lens {} are refused: {}", path,
                                    machine.lenses(i).name(), why),
                        path});
  }
  AddBelowTable(machine, warnings);
  return warnings;
}

}  // namespace intaglio
