#pragma once

// A series: one job for each row of a table, from a pattern. A column is
// - named in braces in a text or file name of the pattern: "{name}" becomes the row's
//   field of the column `name` (placeholders.h); "{n}" is left for the copies of a text;
//   or else
// - a field of the job by its path (field_path.h): block.margin_mm. An empty field of the
//   row leaves the pattern's value.
// A column that is neither is an error, unless its name begins with '#'.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/io/csv.h"
#include "proto/job.pb.h"

namespace intaglio {

/// One row's job. `passed_over`: columns that are for the caller. File names that a row
/// gives are relative to `folder`, the pattern's are absolute. The error's message holds
/// all that is wrong, one a line, each with its field or column, the value and the
/// remedy.
Result<JobSpec> FillRow(const JobSpec& pattern, const io::CsvTable& table,
                        const io::CsvRow& row, const std::filesystem::path& folder,
                        const std::set<std::string>& passed_over = {});

/// All rows; a job whose name holds no column gets the number of its row behind it. The
/// error has every mistake, each with its line of the table; an error in the pattern or
/// in a column is reported with the first row alone. kMissing for a table without rows,
/// or the first mistake's code.
Result<std::vector<JobSpec>> MakeSeries(const JobSpec& pattern, const io::CsvTable& table,
                                        const std::filesystem::path& folder);

/// A job that has its pattern's name gets this behind it.
void NumberEqualNames(JobSpec& job, const JobSpec& pattern, const std::string& what);

}  // namespace intaglio
