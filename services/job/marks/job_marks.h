#pragma once

// What a scan head marks in a job (JobSpec.marks, proto/mark.proto), from its files.
//
// Frame: of the piece, mm. A mark of a repeat k on a web has web_mm = k * pitch: its
// frame's origin is in the middle of the field when the web has run so far since the
// first one's was, and a place of it is then in the field at
// x = place.x + (run of the web - web_mm).

#include <string>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/marks/mark_times.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// Beyond them is kTooLarge: 1 GB.
inline constexpr std::size_t kMaxMarks = 5'000'000;

/// The files that the marks are made from, in the order in which they are taken.
std::vector<std::string> JobMarkFilesOf(const JobSpec& job);

/// Their bytes, from this machine's disks.
Result<std::vector<FileBytes>> ReadJobMarkFiles(const JobSpec& job,
                                                const ReadLimits& limits);

/// All repeats, item by item, in the order of the job; of a filled shape its lines before
/// its contours. `files` as JobMarkFilesOf names them. Errors begin with the field; of a
/// repeat they name its number and its line of the table. kCancelled when `progress`
/// returns that. What files hold that is not marked is added to `warnings`, once for each
/// item. `job` need not have its defaults.
Result<mark::MarkSet> MakeJobMarks(const JobSpec& job, const MachineSpec& machine,
                                   std::vector<FileBytes> files, const ReadLimits& limits,
                                   Warnings& warnings, const ProgressSink& progress);

/// Of the machine's scan_head; a value that is absent is the default.
HeadFigures HeadFiguresOf(const MachineSpec& machine);

/// Whether marks may be made from their end: lines keep their direction where a fill is
/// not bidirectional.
bool MayReverse(const JobSpec& job);

/// The order in which they are made: on a piece at rest with short jumps, on a web so
/// that it may run fast.
/// kOutsideBlock: a mark that does not fit into the field of the machine, by its item.
/// `progress`: of a web, in marks.
Result<mark::MarkSet> OrderJobMarks(const JobSpec& job, const MachineSpec& machine,
                                    mark::MarkSet marks,
                                    const ProgressSink& progress = {});

}  // namespace intaglio
