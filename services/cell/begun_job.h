#pragma once

// The job that a cell has begun, as job.json beside its journal: with the profile, and so
// the zeros, that it is made with. The process that takes the job up compares them with
// the machine as it is now.

#include <filesystem>
#include <optional>

#include "engrave/core/result.h"
#include "proto/task.pb.h"

namespace intaglio::cell {

inline constexpr const char* kJobFile = "job.json";

/// Atomically, into a folder that is there.
Status WriteBegunJob(const std::filesystem::path& folder, const FrozenJob& job);
/// nullopt: there is no file, so nothing was made yet. kUnreadable, kIo.
Result<std::optional<FrozenJob>> ReadBegunJob(const std::filesystem::path& folder);

}  // namespace intaglio::cell
