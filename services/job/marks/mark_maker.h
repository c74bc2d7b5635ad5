#pragma once

// From the files of a job of marks to its marks, and to their order. Which kind of job
// makes them is decided here and nowhere else.

#include <string>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/mark/mark.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// The marks of a frozen job; `files` as MarkFilesOf names them. Errors name the file or
/// the field. kMissing: nothing is to be marked. What files hold that is not marked is
/// added to `warnings`.
Result<mark::MarkSet> MakeMarks(const JobSpec& job, const MachineSpec& machine,
                                std::vector<FileBytes> files, const ReadLimits& limits,
                                Warnings& warnings, const ProgressSink& progress);

/// The same marks in the order in which they are to be made. kRefused: some would be
/// missed at the speed of the web; kCancelled when `progress`, which counts marks,
/// returns that. What was chosen for the user is added to `warnings`.
Result<mark::MarkSet> OrderMarks(const JobSpec& job, const MachineSpec& machine,
                                 mark::MarkSet marks, Warnings& warnings,
                                 const ProgressSink& progress = {});

/// The files that the marks of a frozen job are made from, in the order in which they are
/// sent and taken.
std::vector<std::string> MarkFilesOf(const JobSpec& job);

}  // namespace intaglio
