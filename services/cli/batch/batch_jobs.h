#pragma once

// The jobs of a batch file, complete and checked as the job service checks them, so that
// nothing is submitted when a line is wrong.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "services/cli/batch/batch_plan.h"

namespace intaglio::cli {

struct BatchSource {
  std::filesystem::path file;
  std::string job_file;            ///< of lines that name none; may be empty
  std::vector<std::string> cells;  ///< machine profiles, by name or file; may be empty
  std::filesystem::path materials_db;
};

struct BatchJob {
  std::string id;
  std::string name;
  std::string key;                         ///< submission id; empty: a new one
  std::map<std::string, JobSpec> by_cell;  ///< as each of its machines would make it
  Warnings warnings;                       ///< each with its line
  PlannedJob planned;
};

/// Every mistake of every line, with file, line and id, the field, its value and what is
/// allowed.
Result<std::vector<BatchJob>> BuildBatch(const BatchSource& source);

}  // namespace intaglio::cli
