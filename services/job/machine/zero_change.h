#pragma once

// Whether the zeros that a job is made with are still those of its machine's profile: one
// that was taught meanwhile would put the rest of the job beside what is made already.

#include <string>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// For people: the first channel of `job` whose zero differs between the profile that it
/// was begun with and the profile now, with both places, machine frame, mm. Empty: none
/// does. What the job does not use is not compared.
std::string ZeroChange(const JobSpec& job, const MachineSpec& begun,
                       const MachineSpec& now);

}  // namespace intaglio
