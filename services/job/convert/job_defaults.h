#pragma once

// Fills in what was left open, as documented in proto/job.proto.
// Values that are given stay as they are, right or wrong.

#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Every default but two, which FreezeJob fills in: the weight of a step up of the order
/// Kdz follows from the beam's cone in the glass, and the direction of rows from the
/// speed of the focus there.
JobSpec WithDefaults(JobSpec job, const MachineSpec& machine);

}  // namespace intaglio
