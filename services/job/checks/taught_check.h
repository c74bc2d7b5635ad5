#pragma once

// What is wrong with the taught positions of a machine, by themselves and for a job.
// Errors name the field, its value and the remedy.

#include <vector>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Channels and lenses that the machine has, each pair once; soft limits within the axes'
/// travel; sample and park position within both. `machine` has a kinematics that
/// CheckKinematics passes.
void CheckTaught(const MachineSpec& machine, std::vector<Error>& errors);

/// A model that is made in several channels at once needs one zero for all of them: they
/// may differ by the machine's position tolerance. `job` has its defaults.
void CheckZeros(const JobSpec& job, const MachineSpec& machine, Findings& findings);

}  // namespace intaglio
