#pragma once

// The drives of a machine profile: that of all axes, and those of single axes.

#include <array>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drive/drive_kinds.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Kinds and values in the order of the axes, by the fields that the profile sets.
/// `machine` is checked and has its defaults; without any drive it has no lag.
std::array<drive::DriveParameters, 3> DriveParametersOf(const MachineSpec& machine);

/// The drives of the stage's axes. `machine` is checked and has its defaults.
drive::AxisDrives DrivesOf(const MachineSpec& machine);

/// The same with other mechanics on all axes.
drive::AxisDrives DrivesWith(const drive::MechanicsRatios& ratios,
                             const MachineSpec& machine);

/// How far the mechanics may be off without the profile being wrong: 5 % in frequency or
/// 20 % in damping, either way.
std::array<drive::MechanicsRatios, 4> WrongMechanics();

/// Names of axes and drives that are no drives: unstable by the period of their
/// controller, without a kind, of an axis that there is not. `machine` may be without its
/// defaults; ranges are not regarded.
void CheckDrives(const MachineSpec& machine, std::vector<Error>& errors);

}  // namespace intaglio
