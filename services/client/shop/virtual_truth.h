#pragma once

// The truth of a virtual engraver that agrees with its machine profile.

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "proto/truth.pb.h"
#include "services/job/machine/mounted_parts.h"

namespace intaglio::client {

/// `machine` is a profile with its defaults; of `mounted` everything is known; of a
/// machine that marks nothing is taken from it. The
/// repeatability is 0, not the profile's: the glass then shows what the services do and
/// nothing else; a truth file of the user sets it.
MachineTruth TruthOf(const MachineSpec& machine, const MountedParts& mounted);

/// A mill or a laser cutter with the tool of the job, which has its defaults, over a
/// sheet of the default thickness.
MachineTruth TruthOfMill(const MachineSpec& machine, const Course& course);

}  // namespace intaglio::client
