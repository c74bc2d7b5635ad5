#pragma once

// What `intaglio recording info` and `list` print about a file: as a message for
// programs, and from that as text for people.

#include <string>

#include "proto/recording.pb.h"
#include "services/platform/recording/mcap_reader.h"

namespace intaglio::cli {

/// Writer, time span, counts, attachments, what is left out, missing or damaged.
RecordingInfo InfoOf(const recording::McapReader& reader);
/// A line each.
std::string TextOf(const RecordingInfo& info);

/// The channels by topic, with counts and rates.
RecordingChannels ChannelsIn(const recording::McapReader& reader);
/// A table.
std::string TextOf(const RecordingChannels& channels);

}  // namespace intaglio::cli
