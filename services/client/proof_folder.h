#pragma once

// The proof of a job: glass.ply (the cracks), path.ply (the plan), report.json, views.png
// (of several channels, one each as well), and the verdict, from what the machine's glass
// holds.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/report.pb.h"
#include "proto/task.pb.h"

namespace intaglio::client {

struct ProofInputs {
  std::filesystem::path folder;        ///< where the four files go
  std::filesystem::path job_folder;    ///< the cell's: job.json, path.ply, journal.bin
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

/// CRC-32 of the coordinates in their order, hexadecimal: equal for equal points in the
/// same order, bit for bit. The report's checksums "path" and "glass".
std::string PointChecksum(const PointList& points_mm);

/// The report as report.json has it; kInvalidValue for text that is not UTF-8.
Result<std::string> JsonOf(const JobReport& report);

/// Now, as 2026-01-31T12:00:00Z.
std::string UtcNow();

}  // namespace intaglio::client
