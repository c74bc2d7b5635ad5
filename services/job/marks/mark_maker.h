#pragma once

// From the files of a job of marks to its marks, and to their order. Which kind of job
// makes them is decided here and nowhere else.

#include <string>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// The marks of a frozen job; `files` as MarkFilesOf names them. Errors name the file or
/// the field. kMissing: nothing is to be marked.
Result<mark::MarkSet> MakeMarks(const JobSpec& job, const MachineSpec& machine,
                                std::vector<FileBytes> files, const ReadLimits& limits,
                                const ProgressSink& progress);

/// The same marks in the order in which they are to be made.
Result<mark::MarkSet> OrderMarks(const JobSpec& job, const MachineSpec& machine,
                                 mark::MarkSet marks);

/// The files that the marks of a frozen job are made from, in the order in which they are
/// sent and taken.
std::vector<std::string> MarkFilesOf(const JobSpec& job);

}  // namespace intaglio
