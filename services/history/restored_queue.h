#pragma once

// The queue of a shop out of a backup: what happened after the backup is not in it.

#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::history {

struct RestoredQueue {
  std::string old_results, new_results;  ///< folders of the jobs, then and now
  std::string made_utc;                  ///< of the backup
  /// The journals are those of the backup as well: what a job that had begun made since
  /// is unknown, and it would be made twice. It is ended as failed.
  bool ends_begun = true;
};

/// Changes a queue that no program has open: no open job is armed, and its folders are
/// where they are now. kIo or kUnreadable.
Status AdaptRestoredQueue(const std::filesystem::path& database,
                          const RestoredQueue& restored);

/// The process that has this SQLite database open; 0: none. By the locks that SQLite
/// holds as long as a database with a write-ahead log is open ("File Locking And
/// Concurrency").
int ProcessWith(const std::filesystem::path& database);

/// A copy of an SQLite database as it is at one moment, also while it is written. kIo,
/// kUnreadable (damaged).
Status CopyDatabase(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace intaglio::history
