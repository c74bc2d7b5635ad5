#pragma once

// Two streams of points, batch by batch: as recorded, and as made now.

#include <optional>

#include "proto/replay.pb.h"
#include "services/replayer/recorded_samples.h"

namespace intaglio::replayer {

/// The first place where they differ, bit by bit; absent: nowhere. A missing batch is
/// null; not both are. The topic is left open.
std::optional<SampleDifference> Compare(const CloudBatch* then, const CloudBatch* now);

}  // namespace intaglio::replayer
