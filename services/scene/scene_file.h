#pragma once

// The scene of a recording (scene_maker.h) as a file of its own.

#include <filesystem>

#include "engrave/core/result.h"
#include "services/platform/recording/mcap_reader.h"
#include "services/platform/recording/message_cursor.h"

namespace intaglio::scene {

/// Writes an MCAP file with Protobuf messages to `target`, whole or not at all, from the
/// messages of `query` (its channels are ignored). kMissing: no points are in it, because
/// it has no job of points, or they were left out. kRefused: `target` is the recording.
Status WriteScene(const recording::McapReader& reader,
                  const recording::MessageQuery& query,
                  const std::filesystem::path& target);

}  // namespace intaglio::scene
