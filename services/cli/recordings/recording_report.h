#pragma once

// What `intaglio recording info` and `list` print about a file.

#include <string>

#include "services/platform/recording/mcap_reader.h"

namespace intaglio::cli {

/// Writer, time span, counts, what is missing or damaged, attachments: a line each.
std::string InfoText(const recording::McapReader& reader);

/// A table of the channels: topic, partition, type, count and rate.
std::string ChannelTable(const recording::McapReader& reader);

}  // namespace intaglio::cli
