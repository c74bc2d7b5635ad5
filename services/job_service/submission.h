#pragma once

// From the bytes of a JobSubmission to a frozen job, or to all that is wrong with it.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "engrave/core/result.h"
#include "materials_db/material.h"
#include "proto/task.pb.h"
#include "services/job_service/submission_reader.h"

namespace intaglio::job_service {

using FindMaterial =
    std::function<Result<materials_db::Material>(const std::string& name)>;

/// Reads the machine file, finds the glass, checks and freezes. Uid, epoch and result
/// directory are left open: a job is numbered when it is taken. The error's message holds
/// every mistake, one a line, also when machine or glass are not to be had. It waits for
/// the disks of the files that the job names (submission_reader.h).
Result<FrozenJob> FreezeSubmission(std::span<const std::uint8_t> job_bytes,
                                   const FindMaterial& find_material,
                                   const std::string& software_version);

/// FreezeSubmission with the glasses of this material base, for several threads. Throws
/// StoreError when the base cannot be opened.
SubmissionReader::Read ReadingWith(const std::filesystem::path& materials);

}  // namespace intaglio::job_service
