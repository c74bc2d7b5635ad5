#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>

#include "engrave/core/try.h"
#include "engrave/io/crc32.h"
#include "services/backup/archive.h"
#include "services/backup/archive_sum.h"

namespace intaglio::backup {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTables = R"sql(
CREATE TABLE backup (made_utc TEXT NOT NULL, results TEXT NOT NULL, count INTEGER NOT NULL,
  bytes INTEGER NOT NULL, crc32 INTEGER NOT NULL);
CREATE TABLE files (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE,
  bytes INTEGER NOT NULL, crc32 INTEGER NOT NULL);
CREATE TABLE parts (file INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX parts_file ON parts (file);
)sql";

Status Unwritten(const fs::path& file, const std::string& why) {
  return Fail(ErrorCode::kIo,
              fmt::format("cannot write the backup {}: {}; check that its folder exists "
                          "and may be written, and that its disk has room",
                          file.string(), why),
              file.string());
}

/// The file and its name reach the disk.
Status Sync(const fs::path& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = fd >= 0 && fsync(fd) == 0;
  const int why = errno;
  if (fd >= 0) close(fd);
  return synced ? Status() : Unwritten(path, std::strerror(why));
}

}  // namespace

ArchiveWriter::ArchiveWriter(fs::path target)
    : target_(std::move(target)), temporary_(target_.string() + ".unfinished") {}
ArchiveWriter::ArchiveWriter(ArchiveWriter&&) noexcept = default;

ArchiveWriter::~ArchiveWriter() {
  if (!database_) return;
  database_.reset();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

Result<ArchiveWriter> ArchiveWriter::Create(const fs::path& file) {
  std::error_code error;
  if (fs::exists(file, error)) {
    return Fail(
        ErrorCode::kRefused,
        fmt::format("{} is there already: give the backup another name", file.string()),
        file.string());
  }
  ArchiveWriter writer(fs::absolute(file));
  fs::remove(writer.temporary_, error);
  try {
    writer.database_ = std::make_unique<SQLite::Database>(
        writer.temporary_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, 0);
    SQLite::Database& database = *writer.database_;
    // It is a new file, which counts only when all of it is on the disk.
    database.exec("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");
    database.exec(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                              kArchiveApplicationId, kArchiveVersion));
    database.exec(kTables);
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(Unwritten(file, exception.what()).error());
  }
  return writer;
}

Status ArchiveWriter::Add(const std::string& name, const fs::path& source) {
  std::ifstream in(source, std::ios::binary);
  std::error_code error;
  std::uint64_t left = fs::file_size(source, error);
  if (!in || error) {
    if (!fs::exists(source)) return {};
    return Fail(ErrorCode::kIo,
                fmt::format("{}: cannot be read; check that you may read it, or leave "
                            "its part out with --without",
                            source.string()),
                source.string());
  }
  ArchivedFile file{name};
  const auto id = static_cast<std::int64_t>(files_.size()) + 1;
  std::string part;
  try {
    while (left > 0) {
      part.resize(std::min<std::uint64_t>(left, kPartBytes));
      in.read(part.data(), static_cast<std::streamsize>(part.size()));
      part.resize(static_cast<std::size_t>(in.gcount()));
      if (part.empty()) break;  // it was cut meanwhile
      SQLite::Statement insert(*database_, "INSERT INTO parts VALUES (?, ?)");
      insert.bind(1, id);
      insert.bindNoCopy(2, part.data(), static_cast<int>(part.size()));
      insert.exec();
      left -= part.size();
      file.bytes += part.size();
      file.crc32 = io::Crc32(std::as_bytes(std::span(part)), file.crc32);
    }
    SQLite::Statement insert(*database_, "INSERT INTO files VALUES (?, ?, ?, ?)");
    insert.bind(1, id);
    insert.bind(2, name);
    insert.bind(3, static_cast<std::int64_t>(file.bytes));
    insert.bind(4, static_cast<std::int64_t>(file.crc32));
    insert.exec();
  } catch (const SQLite::Exception& exception) {
    return Unwritten(target_, exception.what());
  }
  files_.push_back(std::move(file));
  return {};
}

Status ArchiveWriter::Finish(const std::string& results, const std::string& made_utc) {
  try {
    SQLite::Statement insert(*database_, "INSERT INTO backup VALUES (?, ?, ?, ?, ?)");
    insert.bind(1, made_utc);
    insert.bind(2, results);
    insert.bind(3, static_cast<std::int64_t>(files_.size()));
    insert.bind(4, static_cast<std::int64_t>(SumOf(files_)));
    insert.bind(5, static_cast<std::int64_t>(Crc32Of(files_, made_utc, results)));
    insert.exec();
  } catch (const SQLite::Exception& exception) {
    return Unwritten(target_, exception.what());
  }
  database_.reset();
  INTAGLIO_TRY(Sync(temporary_));
  std::error_code error;
  fs::rename(temporary_, target_, error);
  if (error) return Unwritten(target_, error.message());
  return Sync(target_.parent_path());
}

}  // namespace intaglio::backup
