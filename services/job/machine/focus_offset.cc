#include "services/job/machine/focus_offset.h"

#include <cmath>

#include "services/job/fields/shapes.h"

namespace intaglio {
namespace {

// Lens catalogues give focal lengths to 0.01 mm: nearer than this is the same lens.
constexpr double kSameFocalLengthMm = 1e-3;

/// 0 when either lens has none: the foci are at the same height.
double LowerBy(const MachineLens* lens, const MachineLens* zero) {
  if (lens == nullptr || zero == nullptr) return 0;
  if (!lens->has_working_distance_mm() || !zero->has_working_distance_mm()) return 0;
  return lens->working_distance_mm() - zero->working_distance_mm();
}

const MachineLens* NamedOrFirst(const MachineSpec& machine, const std::string& name) {
  if (!name.empty()) return FindLensNamed(machine, name);
  return machine.lenses().empty() ? nullptr : &machine.lenses(0);
}

Vec3 ChannelOffsetOf(const MachineSpec& machine, std::uint32_t channel) {
  for (const ChannelPosition& position : machine.channel_positions()) {
    if (position.channel() == channel) return Vec3Of(position.offset_mm());
  }
  return Vec3::Zero();
}

}  // namespace

const MachineLens* FindLens(const MachineSpec& machine, double focal_length_mm) {
  for (const MachineLens& lens : machine.lenses()) {
    if (std::abs(lens.focal_length_mm() - focal_length_mm) < kSameFocalLengthMm)
      return &lens;
  }
  return nullptr;
}

const MachineLens* FindLensNamed(const MachineSpec& machine, std::string_view name) {
  for (const MachineLens& lens : machine.lenses()) {
    if (lens.name() == name) return &lens;
  }
  return nullptr;
}

const MachineLens* MountedLensOf(const MachineSpec& machine) {
  return NamedOrFirst(machine, machine.mounted_lens());
}

Vec3 FocusOffsetOf(const MachineSpec& machine, std::string_view lens,
                   std::uint32_t channel) {
  const double lower_mm =
      LowerBy(FindLensNamed(machine, lens), NamedOrFirst(machine, machine.zero_lens()));
  return ChannelOffsetOf(machine, channel) - lower_mm * Vec3::UnitZ();
}

}  // namespace intaglio
