#pragma once

// A batch that goes on where an earlier run of it has ended: --continue RESULTS.

#include <filesystem>
#include <vector>

#include "engrave/core/result.h"
#include "proto/shop.pb.h"
#include "services/cli/batch/batch_jobs.h"

namespace intaglio::cli {

/// What --results has written. kUnreadable, kNotFound.
Result<BatchResults> ReadBatchResults(const std::filesystem::path& file);

/// The jobs that are still to be made. Left out is what is good, with or without
/// warnings; what comes after it no longer waits for it. A job that had not ended keeps
/// its submission id: it is followed, and not made twice.
std::vector<BatchJob> LeaveOutDone(const std::vector<BatchJob>& jobs,
                                   const BatchResults& earlier);

/// The results of the whole batch: of the earlier run for what was left out, in the order
/// of `jobs`, the whole batch.
BatchResults JoinResults(const std::vector<BatchJob>& jobs, const BatchResults& earlier,
                         const BatchResults& now);

}  // namespace intaglio::cli
