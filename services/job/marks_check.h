#pragma once

// Checks and completes what a scan head marks (proto/mark.proto).

#include <vector>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/findings.h"

namespace intaglio {

/// Every default of mark.proto but the number of repeats, which may follow from the
/// table; of an item's pen that of the job.
Marks WithDefaults(Marks marks);

/// Ranges, what is missing, files that do not exist, and what excludes each other. `job`
/// as it was read, with marks.
std::vector<Finding> CheckMarks(const JobSpec& job);

/// That the machine marks. `job` has marks.
std::vector<Finding> CheckMarksOnMachine(const JobSpec& job, const MachineSpec& machine);

}  // namespace intaglio
