#pragma once

// Whether the write-ahead log of an SQLite database is intact. SQLite reads a log up to
// the first frame whose checksum differs and takes the rest for never written: after
// damage in the middle of it what was stored since is missing without a word. Format:
// "Database File Format", chapter 4 (sqlite.org/fileformat2.html).

#include <filesystem>

#include "engrave/core/result.h"

namespace intaglio::history {

/// kUnreadable, with the remedy: stored changes behind a damaged place would be lost. A
/// torn last change, as a loss of power leaves it, is no damage: it was not stored yet.
/// Nothing may write the log meanwhile. `database`: its log is beside it, "-wal"; none is
/// intact.
Status CheckWriteAheadLog(const std::filesystem::path& database);

/// The same while a job service may write it: what it writes meanwhile looks like damage
/// once, damage is there again.
Status CheckLogInUse(const std::filesystem::path& database);

}  // namespace intaglio::history
