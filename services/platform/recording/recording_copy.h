#pragma once

// One recording from others: whole ones together (merge), a part (cut), or what is left
// of a damaged one (repair).

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/recording/message_cursor.h"

namespace intaglio::recording {

struct CopyOptions {
  std::uint64_t from_ns = 0;  ///< log time, included
  /// Not included; absent: to the end.
  std::optional<std::uint64_t> to_ns = std::nullopt;
  std::vector<std::string> topics;  ///< names of channels' topics; empty: all
  std::string library;              ///< the writing program
};

struct CopyReport {
  std::uint64_t message_count = 0;
  std::uint64_t repeat_count = 0;    ///< left out, because the original is there
  std::uint64_t copy_count = 0;      ///< left out, because another source has it, too
  std::vector<std::string> damages;  ///< of the sources: a sentence each
};

/// Messages in the order of their log time, with all metadata and attachments; what two
/// sources have alike is written once: so are messages that one file of a series repeats
/// of an earlier one (conventions.h), when that is a source, too, and messages that two
/// files have at the same time, as a file and a cut of it. The target appears
/// whole or not at all, and may not be a source.
Result<CopyReport> CopyRecordings(const std::vector<McapReader>& sources,
                                  const std::filesystem::path& target,
                                  const CopyOptions& options);

/// Ids of the channels whose topic is one of `topics`, also ".../disposed" and so on of
/// it; absent for all topics. kNotFound for a name that no channel has.
Result<std::optional<std::set<std::uint16_t>>> ChannelsOf(
    const McapReader& reader, const std::vector<std::string>& topics);

}  // namespace intaglio::recording
