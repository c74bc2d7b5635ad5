#pragma once

// The archive of a backup: one file with the files of a shop, each with its checksum. It
// is an SQLite database (application id "INTB"), so that a person can look into it:
//
//   backup  one row: version, made_utc, results (the folder of the results then), and
//           count, bytes and crc32 of all rows of `files`
//   files   id from 1, name, bytes, crc32 (of the content)
//   parts   file (id), data: a file's content, in parts of at most kPartBytes, by rowid
//
// A name is relative, "/" between its parts: "queue/jobs.db", "jobs/1-ab/journal.bin".
// Errors name the archive and the remedy. From one thread.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace SQLite {
class Database;
}

namespace intaglio::backup {

inline constexpr int kArchiveApplicationId = 1229870146;
inline constexpr int kArchiveVersion = 1;
inline constexpr std::size_t kPartBytes = 1u << 20;

struct ArchivedFile {
  std::string name;
  std::uint64_t bytes = 0;
  std::uint32_t crc32 = 0;  ///< of its content
};

/// Writes an archive beside its place, and puts it there when it is whole.
class ArchiveWriter {
 public:
  /// kRefused: there is a file already. kIo: it cannot be written.
  static Result<ArchiveWriter> Create(const std::filesystem::path& file);
  ArchiveWriter(ArchiveWriter&&) noexcept;
  ~ArchiveWriter();  // abandons what was not finished

  /// As many bytes as the file has when it is opened. A file that is gone by then, as a
  /// temporary one, is left out.
  Status Add(const std::string& name, const std::filesystem::path& source);
  /// `results`, `made_utc`: as in the table. The archive is on the disk then.
  Status Finish(const std::string& results, const std::string& made_utc);
  const std::vector<ArchivedFile>& files() const { return files_; }

 private:
  explicit ArchiveWriter(std::filesystem::path target);

  std::filesystem::path target_, temporary_;
  std::unique_ptr<SQLite::Database> database_;
  std::vector<ArchivedFile> files_;
};

class Archive {
 public:
  /// Reads all of it and compares the checksums. kUnreadable: no archive, one of a newer
  /// program, or a damaged or cut one; kNotFound, kIo.
  static Result<Archive> Open(const std::filesystem::path& file);
  Archive(Archive&&) noexcept;
  ~Archive();

  const std::vector<ArchivedFile>& files() const { return files_; }
  const std::string& results() const { return results_; }
  const std::string& made_utc() const { return made_utc_; }
  /// Writes the content of the file at `index` to `target`, whose folder is made.
  Status Extract(std::size_t index, const std::filesystem::path& target) const;

 private:
  Archive() = default;
  Status ReadRows();
  Status Check() const;
  /// Hands the content over, part by part, and compares its size and checksum.
  Status ReadFile(std::size_t index,
                  const std::function<Status(std::string_view part)>& take) const;
  Status Damaged(const std::string& where) const;

  std::filesystem::path file_;
  std::unique_ptr<SQLite::Database> database_;
  std::vector<ArchivedFile> files_;
  std::string results_, made_utc_;
};

/// Whether a name can be that of a file in an archive: relative, in one of its folders,
/// and leading nowhere else.
bool IsArchiveName(const std::string& name);

}  // namespace intaglio::backup
