#pragma once

#include "idl/job.h"

namespace intaglio::history {

/// The state of a job as programs read it: "queued", "waiting_for_arm", ...
const char* StateName(intaglio_JobState state);
/// Why it is paused, likewise: "operator", "line_lost", ...; empty: it is not.
const char* PauseReasonName(intaglio_PauseReason reason);

}  // namespace intaglio::history
