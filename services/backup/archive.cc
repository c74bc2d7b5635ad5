#include "services/backup/archive.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <string_view>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/crc32.h"
#include "services/backup/archive_sum.h"

namespace intaglio::backup {
namespace {

namespace fs = std::filesystem;

constexpr std::array kFolders = {"queue", "jobs", "materials", "machines"};

std::uint32_t Crc32Of(std::string_view bytes, std::uint32_t before) {
  return io::Crc32(std::as_bytes(std::span(bytes)), before);
}

}  // namespace

std::uint32_t Crc32Of(const std::vector<ArchivedFile>& files, const std::string& made_utc,
                      const std::string& results) {
  std::uint32_t crc = Crc32Of(fmt::format("{}\n{}\n", made_utc, results), 0);
  for (const ArchivedFile& file : files)
    crc = Crc32Of(fmt::format("{}\n{}\n{}\n", file.name, file.bytes, file.crc32), crc);
  return crc;
}

std::uint64_t SumOf(const std::vector<ArchivedFile>& files) {
  std::uint64_t bytes = 0;
  for (const ArchivedFile& file : files) bytes += file.bytes;
  return bytes;
}

bool IsArchiveName(const std::string& name) {
  const fs::path path(name);
  if (name.empty() || name.find('\0') != std::string::npos || path.is_absolute())
    return false;
  if (path.lexically_normal().string() != name ||
      std::distance(path.begin(), path.end()) < 2)
    return false;
  if (std::any_of(path.begin(), path.end(),
                  [](const fs::path& part) { return part.empty() || part == ".."; }))
    return false;
  return std::find(kFolders.begin(), kFolders.end(), path.begin()->string()) !=
         kFolders.end();
}

Archive::Archive(Archive&&) noexcept = default;
Archive::~Archive() = default;

Status Archive::Damaged(const std::string& where) const {
  return Fail(ErrorCode::kUnreadable,
              fmt::format("the backup {} is damaged ({}): use another one; nothing was "
                          "changed",
                          file_.string(), where),
              file_.string());
}

Result<Archive> Archive::Open(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("the backup {} is not there: give the file that `intaglio "
                            "backup` has made",
                            file.string()),
                file.string());
  }
  Archive archive;
  archive.file_ = file;
  try {
    archive.database_ =
        std::make_unique<SQLite::Database>(file.string(), SQLite::OPEN_READONLY, 0);
    archive.database_->exec("PRAGMA trusted_schema = OFF");
    INTAGLIO_TRY(archive.ReadRows());
    INTAGLIO_TRY(archive.Check());
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(archive.Damaged(exception.what()).error());
  }
  return archive;
}

Status Archive::ReadRows() {
  const int id = database_->execAndGet("PRAGMA application_id").getInt();
  const int version = database_->execAndGet("PRAGMA user_version").getInt();
  if (id != kArchiveApplicationId) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{} is no backup of a shop; give the file that `intaglio "
                            "backup` has made; nothing was changed",
                            file_.string()),
                file_.string());
  }
  if (version != kArchiveVersion) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the backup {} has version {}, this program reads {}; use "
                            "the program that made it; nothing was changed",
                            file_.string(), version, kArchiveVersion),
                file_.string());
  }
  const int tables = database_
                         ->execAndGet(
                             "SELECT count(*) FROM sqlite_master WHERE type = "
                             "'table' AND name IN ('backup', 'files', 'parts')")
                         .getInt();
  if (tables != 3) return Damaged("tables are missing");
  SQLite::Statement rows(*database_, "SELECT name, bytes, crc32 FROM files ORDER BY id");
  while (rows.executeStep()) {
    files_.push_back({rows.getColumn(0).getString(),
                      static_cast<std::uint64_t>(rows.getColumn(1).getInt64()),
                      static_cast<std::uint32_t>(rows.getColumn(2).getInt64())});
    if (!IsArchiveName(files_.back().name)) return Damaged("the name of a file");
  }
  SQLite::Statement about(*database_,
                          "SELECT made_utc, results, count, bytes, crc32 FROM backup");
  if (!about.executeStep()) return Damaged("its first row");
  made_utc_ = about.getColumn(0).getString();
  results_ = about.getColumn(1).getString();
  if (about.getColumn(2).getInt64() != static_cast<std::int64_t>(files_.size()) ||
      about.getColumn(3).getInt64() != static_cast<std::int64_t>(SumOf(files_)) ||
      about.getColumn(4).getInt64() !=
          static_cast<std::int64_t>(Crc32Of(files_, made_utc_, results_))) {
    return Damaged("its list of files");
  }
  return {};
}

Status Archive::Check() const {
  for (std::size_t i = 0; i < files_.size(); ++i)
    INTAGLIO_TRY(ReadFile(i, [](std::string_view) { return Status(); }));
  return {};
}

Status Archive::ReadFile(std::size_t index,
                         const std::function<Status(std::string_view part)>& take) const {
  const ArchivedFile& file = files_.at(index);
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  try {
    SQLite::Statement parts(*database_,
                            "SELECT data FROM parts WHERE file = ? ORDER BY rowid");
    parts.bind(1, static_cast<std::int64_t>(index) + 1);
    while (parts.executeStep()) {
      const SQLite::Column data = parts.getColumn(0);
      const std::string_view part(static_cast<const char*>(data.getBlob()),
                                  static_cast<std::size_t>(data.getBytes()));
      bytes += part.size();
      crc = Crc32Of(part, crc);
      INTAGLIO_TRY(take(part));
    }
  } catch (const SQLite::Exception& exception) {
    return Damaged(fmt::format("{}: {}", file.name, exception.what()));
  }
  if (bytes != file.bytes || crc != file.crc32) return Damaged(file.name);
  return {};
}

Status Archive::Extract(std::size_t index, const fs::path& target) const {
  std::error_code ignored;
  fs::create_directories(target.parent_path(), ignored);
  auto out = INTAGLIO_TRY(io::AtomicFile::Create(target));
  INTAGLIO_TRY(
      ReadFile(index, [&out](std::string_view part) { return out.Write(part); }));
  return out.Commit();
}

}  // namespace intaglio::backup
