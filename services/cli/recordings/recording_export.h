#pragma once

// What is in a recording, for other programs: JSON lines, a table, or the cracks.

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/recording/message_cursor.h"

namespace intaglio::cli {

/// One JSON object a message: topic, partition, sample, sequence, log_time_ns,
/// publish_time_ns and value, the message decoded by its schema.
Status ExportJsonLines(const recording::McapReader& reader,
                       const recording::MessageQuery& query, std::ostream& out);

/// The messages of one topic as a table after RFC 4180: times, sequence, partition, and a
/// column for each member of the type, "a.b" for members of members; lists are JSON.
Status ExportCsv(const recording::McapReader& reader, const std::string& topic,
                 const recording::MessageQuery& query, std::ostream& out);

/// Every point that was made, once, at its place in the glass frame, mm, with the columns
/// tick and point, in the order of the ticks: from PulseEventBatch and PathBatch. For
/// points whose place is not in the recording, `path`, a path.ply, is read; empty: none.
/// kMissing when a place is nowhere. `job`: uid or number of the job; empty: the only
/// one.
Status ExportCracks(const recording::McapReader& reader, const std::string& job,
                    const std::filesystem::path& path,
                    const std::filesystem::path& target);

}  // namespace intaglio::cli
