#pragma once

// A profile with what a measurement of the machine found.

#include <string>
#include <vector>

#include "engrave/calibrate/machine_fit.h"
#include "proto/machine.pb.h"

namespace intaglio::client {

struct CorrectedProfile {
  MachineSpec machine;
  /// What differs, "cartesian.x.scale_ratio: 1 -> 1.0004".
  std::vector<std::string> corrections;
  /// What a profile cannot correct, or should not, and what to do.
  std::vector<std::string> remarks;
};

/// Scales, squareness and lag that differ from those of the profile by more than their
/// uncertainty; places that were found by driving to them (block_origin_mm, taught zeros)
/// are kept where they are in the block. `machine` has three linear axes and passes
/// CheckMachine.
CorrectedProfile Correct(const MachineSpec& machine, const calibrate::MachineFit& fit);

/// What the profile's places were made with.
calibrate::KnownGeometry KnownGeometryOf(const MachineSpec& machine);

}  // namespace intaglio::client
