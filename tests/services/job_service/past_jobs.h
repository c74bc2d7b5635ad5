#pragma once

// A shop with a long past: a queue's database with many jobs that have ended.

#include <cstdint>
#include <filesystem>

namespace intaglio::job_service {

/// Adds `count` ended jobs to the database, numbered from 1, their ends a minute apart
/// from 2020-01-01 on, each with a submission, three stages, three tasks and a frozen job
/// of `frozen_bytes`. The file is made when there is none.
void AddPastJobs(const std::filesystem::path& database, std::uint32_t count,
                 std::uint32_t frozen_bytes);

}  // namespace intaglio::job_service
