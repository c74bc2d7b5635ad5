#pragma once

// From a task to a job that can be marked: its folder with marks and journal. It waits
// for the disk.

#include <memory>
#include <optional>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/cell/journal_writer.h"
#include "services/marker/marking.h"

namespace intaglio::marker {

/// In a job's folder, beside its journal and job.json.
inline constexpr const char* kMarksFile = "marks.bin";
inline constexpr const char* kJournalFile = "journal.bin";

struct PreparedMarking {
  MarkingJob job;
  std::shared_ptr<cell::JournalWriter> journal;
};

/// `marks`: none when the job was begun: they are in its folder. kRefused, kUnreadable,
/// kIo as of cell::OpenJournal; kNotFound: the marks of a job that was begun are gone;
/// kCancelled when `progress` returns false.
Result<PreparedMarking> PrepareMarking(const FrozenJob& job,
                                       std::optional<mark::MarkSet> marks,
                                       const ProgressSink& progress);

/// The task was made for another profile than this machine's. kRefused, field by field.
Status CheckMarkTask(const FrozenJob& job, const MachineSpec& machine);

}  // namespace intaglio::marker
