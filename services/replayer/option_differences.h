#pragma once

// The options in which two frozen jobs differ.

#include <vector>

#include "proto/replay.pb.h"
#include "proto/task.pb.h"

namespace intaglio::replayer {

/// By field, in the order of the messages. Names of the job, folders and the software's
/// version are no options.
std::vector<OptionDifference> OptionDifferences(const FrozenJob& then,
                                                const FrozenJob& now);

}  // namespace intaglio::replayer
