#pragma once

// What is wrong with a job or a machine profile: everything at once, each with the
// field's path, the value and what is allowed, e.g.
//   models[1].placement.fit_height_mm: 2000 is outside 0.1..1000

#include <optional>
#include <vector>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// The job by itself: ranges, required fields, model files that are there. Fields that
/// have a default may be absent.
std::vector<Finding> CheckJob(const JobSpec& job);

/// The profile by itself.
std::vector<Error> CheckMachine(const MachineSpec& machine);

/// Its kinematics and the limits of its axes, a part of CheckMachine. machine_axes.h
/// takes only what passes.
std::vector<Error> CheckKinematics(const MachineSpec& machine);

/// Checks the two against each other: rate, lens, limits, room for the block in the reach
/// and the travel of the axes. The depth of the block takes as much z travel as the glass
/// makes of it; without `stage_per_glass_ratio` (OpticalValuesRecord) only the block's
/// top is checked. Both are taken with their defaults filled in.
std::vector<Finding> CheckJobOnMachine(const JobSpec& job, const MachineSpec& machine,
                                       std::optional<double> stage_per_glass_ratio = {});

/// CheckMachine, CheckJob and CheckJobOnMachine together, at most one of a job's field.
std::vector<Finding> CheckAll(const JobSpec& job, const MachineSpec& machine,
                              std::optional<double> stage_per_glass_ratio = {});

/// All of them as one, one a line. Precondition: there is at least one.
Error JoinErrors(const std::vector<Error>& errors);
Error JoinErrors(const std::vector<Finding>& findings);

}  // namespace intaglio
