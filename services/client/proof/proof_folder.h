#pragma once

// The proof of a job: glass.ply (the cracks), path.ply (the plan), report.json, views.png
// (of several channels, one each as well), and the verdict. Of a job of marks burnt.rec
// (what was burnt) and marks.bin (the plan) are in place of the first two, on a virtual
// mill cut.rec (what its tool did) and sheet.png (what it left). `run` makes it
// of everything that its machine's glass or piece holds; in a shop a job's folder is
// completed when the job has ended.

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/report.pb.h"
#include "proto/task.pb.h"
#include "services/client/proof/evidence/proof_evidence.h"
#include "services/client/proof/evidence/proof_files.h"
#include "services/client/proof/marks/mark_evidence.h"

namespace intaglio::client {

struct ProofInputs {
  std::filesystem::path folder;  ///< where the files go
  /// The cell's: job.json, path.ply or marks.bin, journal.bin.
  std::filesystem::path job_folder;
  std::filesystem::path glass_record;  ///< the machine's own
  std::optional<StageOutcome> discretize, sort, engrave;
  Warnings warnings;                 ///< all that are known of the job
  std::string breakage_accepted_by;  ///< empty: nobody
  std::string started_utc, ended_utc;
  double wall_time_s = 0;
  std::uint32_t job_number = 0;
};

/// A job's folder has points or marks in their order: its making had begun.
bool HasPlan(const std::filesystem::path& folder);

/// Writes the files and returns the report. Errors are those of reading what the run left
/// behind and of the disk.
Result<JobReport> MakeProof(const ProofInputs& inputs);

struct ProvedFolder {
  /// Where the glass is known, it has what the pictures need (FiguresOf).
  std::variant<Evidence, MarkEvidence> evidence;
  JobReport report;
  bool lost_proof = false;           ///< AddLostProof
  std::optional<Error> not_written;  ///< Why a file of the proof is missing.
};

/// Reads a folder of `run` or of a shop's job again. What its report.json, or its
/// stages.json and statistics.json have of stages, times and warnings is kept. Writes
/// nothing.
Result<ProvedFolder> VerifyFolder(const std::filesystem::path& folder);

struct FolderToComplete {
  std::filesystem::path folder;
  /// With the records of the virtual engraver or head; empty: the shop's, the second
  /// above.
  std::filesystem::path glass_folder;
  bool renew = false;  ///< also what is there already
};

/// The same, and writes glass.ply or burnt.rec, if the glass or the piece is known, views
/// and report. A job that has not ended is read alone.
Result<ProvedFolder> CompleteFolder(const FolderToComplete& which);

/// The folders of jobs in a shop's folder `jobs`, by name: those of which something was
/// engraved. Empty when `folder` is the folder of one job itself, or has none.
std::vector<std::filesystem::path> JobFoldersIn(const std::filesystem::path& folder);

/// The report as report.json has it; kInvalidValue for text that is not UTF-8.
Result<std::string> JsonOf(const JobReport& report);

/// Now, as 2026-01-31T12:00:00Z.
std::string UtcNow();

}  // namespace intaglio::client
