#pragma once

// Batch files: many jobs with their order, priorities and machines (docs/jobs.md).
//
// JSON lines, ending .jsonl or .ndjson: a BatchEntry (proto/shop.proto) a line, from the
// first { to its }; empty lines are passed over. Or CSV over a job file: the columns id,
// after (ids, blanks between), cell, job and key are those of BatchEntry, the others are
// as in services/job/files/series.h. Overrides of JSON are one row of such a table.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/io/csv.h"
#include "proto/job.pb.h"
#include "proto/shop.pb.h"

namespace intaglio {

/// A line of the file that can be read; values as text
/// (services/job/fields/field_path.h).
struct BatchLine {
  std::string id;
  std::string job_file;  ///< empty: the one that the batch was given
  std::vector<std::string> after;
  std::string cell;
  std::string key;       ///< submission id (submission_id.h); empty: a new one
  io::CsvTable columns;  ///< its one row has what the job is given
  std::size_t line_number = 0;
};

struct BatchLimits {
  std::size_t max_bytes = 16 << 20;
  std::size_t max_jobs = 10'000;
};

/// What is wrong with the lines by themselves, all of it, each with its line:
/// kUnreadable, kInvalidValue, kMissing (no job), kTooLarge.
Result<std::vector<BatchLine>> ParseBatchJson(std::string_view text,
                                              const BatchLimits& limits = {});
Result<std::vector<BatchLine>> ParseBatchCsv(std::string_view text,
                                             const BatchLimits& limits = {});

/// By the ending; the error's lines name the file.
Result<std::vector<BatchLine>> ReadBatchFile(const std::filesystem::path& file);

/// What is wrong with the order, all of it: an id that is given twice, an `after` that is
/// no id, and jobs that wait for each other in a circle.
std::vector<Error> CheckBatchOrder(const std::vector<BatchLine>& lines);

/// The job of a line. `pattern` has absolute paths; errors as FillRow's.
Result<JobSpec> JobOf(const BatchLine& line, const JobSpec& pattern,
                      const std::filesystem::path& folder);

}  // namespace intaglio
