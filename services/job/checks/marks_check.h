#pragma once

// Checks what a scan head marks (proto/mark.proto).

#include <vector>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Ranges, what is missing, files that do not exist, and what excludes each other. `job`
/// as it was read, with marks.
std::vector<Finding> CheckMarks(const JobSpec& job);

/// That the machine marks. `job` has marks.
std::vector<Finding> CheckMarksOnMachine(const JobSpec& job, const MachineSpec& machine);

}  // namespace intaglio
