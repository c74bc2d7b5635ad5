#pragma once

// Whether a job may be fired into the block that is known to be in the machine: into
// another one its points would come at other depths, or beside the glass.

#include <string>

#include "engrave/core/geometry.h"

namespace intaglio {

/// Both sizes and the remedy at this machine; empty when it fits: the top faces, through
/// which the beam is focused, are at one height, within 1 um, and the block in the
/// machine is at least as wide and as deep. Sizes in mm, > 0.
std::string BlockMisfit(const Vec3& job_size_mm, const Vec3& in_machine_mm,
                        const std::string& machine);

/// The command that reports what is mounted in this machine, without its parts. The name
/// is always in it: a shop may have several machines.
std::string MountCommand(const std::string& machine);

}  // namespace intaglio
