#pragma once

// A series: one job for each row of a table, from a pattern that names its columns.

#include <vector>

#include "engrave/core/result.h"
#include "engrave/formats/csv.h"
#include "proto/job.pb.h"

namespace intaglio {

/// In every text and file name of the pattern, "{name}" becomes the field of the column
/// of that name; "{n}" is left for the copies of a text. A job whose name holds no column
/// gets the number of its row behind it. Errors, with the field's path: kNotFound for a
/// column that the table does not have, and kMissing for a table without rows or a
/// pattern without a column: all pieces would be alike.
Result<std::vector<JobSpec>> MakeSeries(const JobSpec& pattern,
                                        const formats::CsvTable& table);

}  // namespace intaglio
