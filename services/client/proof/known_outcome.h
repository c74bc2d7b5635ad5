#pragma once

// What the files of a job's folder have of its stages, times and warnings, besides what
// can be measured again.

#include <filesystem>

#include "engrave/core/result.h"
#include "proto/report.pb.h"
#include "proto/shop.pb.h"

namespace intaglio::client {

/// Adds them to a report of the folder's figures: from its report.json, else from
/// stages.json and statistics.json. Nothing of a file that is not there or not readable.
void AddKnown(const std::filesystem::path& folder, JobReport& report);

/// The folder's report.json was proved by the glass or the piece, while `report` has only
/// the controller's counters, because the record is missing now. Its verdict gets the
/// faults that were found then, and the reason why it is not good without warnings.
/// Precondition: it is judged. False: nothing was lost, and nothing is added.
bool AddLostProof(const std::filesystem::path& folder, JobReport& report);

/// Adds the outcomes of the stages, and what follows from them.
void AddStages(const JobStages& stages, JobReport& report);

/// kNotFound, kUnreadable.
Result<JobStatistics> ReadStatistics(const std::filesystem::path& folder);

/// The statistics of the folder say that the job may still be engraved.
bool IsOpen(const std::filesystem::path& folder);

}  // namespace intaglio::client
