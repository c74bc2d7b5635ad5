#pragma once

// Where the focus of a lens and of a channel is, relative to the one with which the
// machine's zero was measured. Machine frame, mm.

#include <cstdint>
#include <string_view>

#include "engrave/core/geometry.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// The machine's lens of this focal length; nullptr when it has none.
const MachineLens* FindLens(const MachineSpec& machine, double focal_length_mm);

/// nullptr: the machine has no lens of this name.
const MachineLens* FindLensNamed(const MachineSpec& machine, std::string_view name);

/// MachineSpec.mounted_lens, or the first; nullptr: the machine has none.
const MachineLens* MountedLensOf(const MachineSpec& machine);

/// The focus of this lens and channel (from 1) minus that of zero_lens and channel 1, at
/// the same axes. A longer working distance puts it lower.
Vec3 FocusOffsetOf(const MachineSpec& machine, std::string_view lens,
                   std::uint32_t channel);

}  // namespace intaglio
