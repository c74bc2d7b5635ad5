#pragma once

#include "idl/job.h"

namespace intaglio::history {

/// The state of a job as programs read it: "queued", "waiting_for_arm", ...
const char* StateWord(intaglio_JobState state);

}  // namespace intaglio::history
