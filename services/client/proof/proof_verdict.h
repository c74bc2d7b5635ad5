#pragma once

// The verdict of a report, by its figures and its warnings.

#include <filesystem>

#include "proto/report.pb.h"

namespace intaglio::client {

/// Fills the verdict in: not_good with what is wrong; good_with_warnings with the
/// warnings that say that the piece may look wrong, or that the glass may break; good.
void Judge(JobReport& report);

/// Takes the warnings and the consent over from a report.json of any version; nothing of
/// a file that is not there or not readable. Older ones have sentences alone: notes.
void AddWarningsOf(const std::filesystem::path& report_file, JobReport& report);

}  // namespace intaglio::client
