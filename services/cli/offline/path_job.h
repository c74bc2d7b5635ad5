#pragma once

// The job of a command that has the points already: their machine, glass and options.

#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/cli/job/job_options.h"

namespace intaglio::cli {

/// Job, machine and optical values as a service gets them; no model is needed, and
/// without a block one is chosen that holds the points. `materials_db` empty: the user's
/// base. The names and figures of the error are those of BuildJob.
Result<FrozenJob> BuildPathJob(const JobFlags& flags, const PointList& points_mm,
                               const std::string& materials_db);

/// Lets the stage go anywhere, for a path whose zero is not the machine's.
void ForgetTravel(MachineSpec& machine);

/// kOutsideBlock for the first point outside the job's block; frame glass.
Status RequireInBlock(const FrozenJob& job, const PointList& points_mm);

}  // namespace intaglio::cli
