#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "engrave/core/try.h"
#include "services/backup/shop_backup.h"
#include "services/history/job_database.h"
#include "services/history/restored_queue.h"
#include "services/history/write_ahead_log.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::backup {
namespace {

namespace fs = std::filesystem;

/// A file that goes with this.
struct Temporary {
  fs::path file;
  ~Temporary() {
    std::error_code ignored;
    fs::remove(file, ignored);
  }
};

Status AddDatabase(ArchiveWriter& writer, const std::string& name, const fs::path& from,
                   const fs::path& beside) {
  const Temporary copy{beside.string() + ".copy"};
  std::error_code ignored;
  fs::remove(copy.file, ignored);
  INTAGLIO_TRY(history::CopyDatabase(from, copy.file));
  return writer.Add(name, copy.file);
}

/// Regular files below a folder, in the order of their names; links are not followed.
std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator
           at(folder, fs::directory_options::skip_permission_denied, error),
       end;
       !error && at != end; at.increment(error)) {
    if (at->is_regular_file(error) && !at->is_symlink(error)) files.push_back(at->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// `backup`: the file that is written, which may be in the folder.
Status AddFolder(ArchiveWriter& writer, const std::string& part, const fs::path& folder,
                 const fs::path& backup) {
  for (const fs::path& file : FilesIn(folder)) {
    if (file.string().starts_with(fs::absolute(backup).string())) continue;
    INTAGLIO_TRY(
        writer.Add(part + "/" + file.lexically_relative(folder).generic_string(), file));
  }
  return {};
}

bool IsProfile(const fs::path& file, const fs::path& folder) {
  const fs::path relative = file.lexically_relative(folder);
  const fs::path first = *relative.begin();
  const bool is_alone = std::next(relative.begin()) == relative.end();
  return is_alone ? first.extension() == ".textproto"
                  : first.string().ends_with(".textproto.history");
}

Status AddProfiles(ArchiveWriter& writer, const fs::path& folder) {
  for (const fs::path& file : FilesIn(folder)) {
    if (!IsProfile(file, folder)) continue;
    INTAGLIO_TRY(
        writer.Add("machines/" + file.lexically_relative(folder).generic_string(), file));
  }
  return {};
}

/// The queue is there and, as far as it can be seen from outside, intact.
Status CheckSource(const fs::path& database) {
  std::error_code error;
  if (!fs::exists(database, error) && !fs::exists(database.string() + "-wal", error)) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{}: no queue of a shop: give its folder with --folder, or "
                            "the job service's --database",
                            database.string()),
                database.string());
  }
  if (history::ProcessWith(database) == 0) return history::CheckQueue(database);
  INTAGLIO_TRY(history::CheckJobDatabase(database));
  return history::CheckLogInUse(database);
}

}  // namespace

Result<std::vector<ArchivedFile>> BackUp(const ShopPlaces& places, const Parts& without,
                                         const fs::path& file) {
  const auto has = [&without](const char* part) { return !without.contains(part); };
  if (has("queue")) INTAGLIO_TRY(CheckSource(places.database));
  auto writer = INTAGLIO_TRY(ArchiveWriter::Create(file));
  const std::string now = host::UtcText(std::chrono::system_clock::now());
  if (has("queue"))
    INTAGLIO_TRY(AddDatabase(writer, "queue/jobs.db", places.database, file));
  if (has("jobs")) INTAGLIO_TRY(AddFolder(writer, "jobs", places.results, file));
  std::error_code error;
  if (has("materials") && fs::exists(places.materials, error))
    INTAGLIO_TRY(AddDatabase(writer, "materials/materials.db", places.materials, file));
  if (has("machines")) INTAGLIO_TRY(AddProfiles(writer, places.machines));
  INTAGLIO_TRY(writer.Finish(fs::absolute(places.results).string(), now));
  return writer.files();
}

}  // namespace intaglio::backup
