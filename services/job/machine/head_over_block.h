#pragma once

// The scan head of a machine profile over the block: its optics, what its pulses need,
// and what is wrong with it.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/machine/kinematics.h"
#include "engrave/sort/jump_layers.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Lens and correction; the axis z and the block are the caller's to set. Of a head that
/// CheckHeadOverBlock passes.
machine::ScanHeadOptions HeadOptionsOf(const HeadOverBlockKinematics& head);

/// How far the focus goes in the focal plane for 1 mm of x, and of y.
Vec2 FieldScaleOf(const FieldShape& field);

/// Times of a head with jump_and_dwell; its z: the machine's axis.
sort::JumpTimes JumpTimesOf(const MachineSpec& machine);

/// The least pulse energy that makes a crack with an upright beam, mJ.
double CrackEnergyMj(const MachineSpec& machine);

/// Besides ranges, axes and z.
void CheckHeadOverBlock(const MachineSpec& machine, std::vector<Error>& errors);

}  // namespace intaglio
