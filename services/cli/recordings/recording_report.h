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

/// Prints what is missing in the file to the standard error stream, a line each, beside
/// what a command prints for programs.
void PrintMissing(const recording::McapReader& reader);

}  // namespace intaglio::cli
