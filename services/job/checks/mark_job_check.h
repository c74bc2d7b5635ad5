#pragma once

// Checks jobs of marks on the machines that make them (services/job/fields/job_kind.h).

#include <vector>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Everything that is wrong with a job of marks on this machine, the machine's own fields
/// left out: also that one of them makes points.
std::vector<Finding> CheckMarkJob(const JobSpec& job, const MachineSpec& machine);

/// That points in a block may be asked of this machine. kUnsupported: it makes marks, or
/// contours.
Status CheckMakesPoints(const MachineSpec& machine);

}  // namespace intaglio
