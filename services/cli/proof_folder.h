#pragma once

// The proof of a job: glass.ply (the cracks), path.ply (the plan), report.json and
// views.png, and the verdict, from what the machine's glass holds.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/report.pb.h"
#include "proto/task.pb.h"

namespace intaglio::cli {

struct ProofInputs {
  std::filesystem::path folder;        ///< where the four files go
  std::filesystem::path job_folder;    ///< the cell's: job.json, path.ply, journal-N.bin
  std::filesystem::path glass_record;  ///< the machine's own
  std::optional<StageOutcome> discretize, sort, engrave;
  std::vector<std::string> warnings;
  std::string started_utc, ended_utc;
  double wall_time_s = 0;
};

/// Writes the four files and returns the report. Errors are those of reading what the
/// run left behind and of the disk.
Result<JobReport> MakeProof(const ProofInputs& inputs);

/// Compares glass.ply, path.ply and the journal of a finished folder again.
Result<JobReport> VerifyFolder(const std::filesystem::path& folder);

/// The report in a few lines for the terminal.
std::string SummaryOf(const JobReport& report);

/// Now, as 2026-01-31T12:00:00Z.
std::string UtcNow();

}  // namespace intaglio::cli
