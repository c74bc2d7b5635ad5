#pragma once

// How long a part of a machine's supervision may be away before an arm ends. An arm is a
// person's statement about the block that is in the machine now. It survives a process or
// a line that comes back within this time, because no person can change a block and leave
// in less; after a longer absence the block may be another one, and the job waits for a
// new arm.
//
// The one limit for every absence: of the synchronizer and of the job service (judged by
// the job service), of the laser controller and of the motion controller (judged by the
// synchronizer). docs/jobs.md states it.

#include <chrono>

namespace intaglio::host {

inline constexpr std::chrono::seconds kMaxAbsence{30};

}  // namespace intaglio::host
