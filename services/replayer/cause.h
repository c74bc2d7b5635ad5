#pragma once

// Why a service makes a different result now than in the recording.

#include <functional>

#include "engrave/core/result.h"
#include "proto/replay.pb.h"

namespace intaglio::replayer {

/// Fills in `cause` and `explanation` of a comparison whose options and versions are
/// there; the causes in the order of rehearsal.h. What differs had all its input: what
/// the recording lacks is of tasks that were not compared. `differs_again`: the same
/// input gives a third result when repeated.
Status NameCause(ReplayComparison& result,
                 const std::function<Result<bool>()>& differs_again);

}  // namespace intaglio::replayer
