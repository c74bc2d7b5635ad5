#pragma once

// What the synchronizer keeps of a job beside its journal, on the cell's host: the path
// and the job, written before anything is fired, and read by the synchronizer that takes
// the job up.

#include <filesystem>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/task.pb.h"

namespace intaglio::synchronizer {

inline constexpr const char* kPathFile = "path.ply";
inline constexpr const char* kJournalFile = "journal.bin";

/// kIo when there is none and it cannot be made.
Status MakeJobFolder(const std::filesystem::path& folder);
/// path.ply and job.json. `path`: glass frame, mm, in the order of engraving.
Status WritePlan(const std::filesystem::path& folder, const FrozenJob& job,
                 const PointCloud& path);
/// kNotFound when nothing of the job was engraved; kUnreadable.
Result<PointCloud> ReadPath(const std::filesystem::path& folder);

}  // namespace intaglio::synchronizer
