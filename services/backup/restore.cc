#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "engrave/core/try.h"
#include "services/backup/shop_backup.h"
#include "services/history/restored_queue.h"
#include "services/platform/host/times/utc_time.h"

// Everything is written beside its place first. Then what is there is renamed, and what
// was written is renamed to its place; a rename that fails takes those before it back.

namespace intaglio::backup {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStagedEnding = ".restoring";

/// What is put to one place: a file, or a folder.
struct Place {
  fs::path target;
  fs::path staged() const { return target.string() + kStagedEnding; }
};

/// The place that a file of the archive belongs to, and its path in what is staged.
Place PlaceOf(const std::string& name, const ShopPlaces& places, fs::path& staged) {
  const fs::path path(name);
  const fs::path rest = path.lexically_relative(*path.begin());
  const std::string part = path.begin()->string();
  Place place;
  if (part == "jobs") {
    place.target = places.results;
    staged = place.staged() / rest;
    return place;
  }
  if (part == "queue") place.target = places.database;
  if (part == "materials") place.target = places.materials;
  if (part == "machines") {
    place.target = places.machines / *rest.begin();
    const bool is_file = std::next(rest.begin()) == rest.end();
    staged = is_file ? place.staged()
                     : place.staged() / rest.lexically_relative(*rest.begin());
    return place;
  }
  staged = place.staged();
  return place;
}

/// What belongs to a place: SQLite's log, and when the job service was last there.
std::vector<fs::path> FilesOf(const fs::path& target) {
  std::vector<fs::path> files = {target};
  for (const char* ending : {"-wal", "-shm", ".seen"})
    files.push_back(target.string() + ending);
  return files;
}

bool IsThere(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) ? !fs::is_empty(path, error)
                                       : fs::exists(path, error);
}

class Restoring {
 public:
  Restoring(const Archive& archive, const RestoreOptions& options)
      : archive_(archive), options_(options) {}
  ~Restoring() {
    std::error_code ignored;
    for (const fs::path& target : targets_)
      fs::remove_all(target.string() + kStagedEnding, ignored);
  }
  Restoring(const Restoring&) = delete;
  Restoring& operator=(const Restoring&) = delete;

  Result<std::vector<fs::path>> Run() {
    Collect();
    INTAGLIO_TRY(CheckPlaces());
    INTAGLIO_TRY(Stage());
    if (const Status put = Put(); !put) {
      for (auto at = renamed_.rbegin(); at != renamed_.rend(); ++at) {
        std::error_code ignored;
        fs::rename(at->second, at->first, ignored);
      }
      return tl::unexpected(put.error());
    }
    return kept_;
  }

 private:
  bool Takes(const std::string& name) const {
    return !options_.without.contains(fs::path(name).begin()->string());
  }

  void Collect() {
    for (const ArchivedFile& file : archive_.files()) {
      fs::path ignored;
      if (Takes(file.name))
        targets_.insert(PlaceOf(file.name, options_.places, ignored).target);
    }
  }

  Status CheckPlaces() const {
    const fs::path& queue = options_.places.database;
    if (const int process = history::ProcessWith(queue); process != 0) {
      return Fail(ErrorCode::kRefused,
                  fmt::format("the process {} has the queue {} open: close that shop, "
                              "then restore it; nothing was changed",
                              process, queue.string()),
                  queue.string());
    }
    if (options_.replace) return {};
    std::vector<std::string> there;
    for (const fs::path& target : targets_) {
      const auto files = FilesOf(target);
      if (std::any_of(files.begin(), files.end(), IsThere))
        there.push_back(target.string());
    }
    if (there.empty()) return {};
    return Fail(ErrorCode::kRefused,
                fmt::format("{} is there already: --replace keeps it beside what is "
                            "restored, --without PART leaves a part as it is; nothing "
                            "was changed",
                            fmt::join(there, ", ")),
                there.front());
  }

  Status Stage() {
    std::error_code error;
    for (const fs::path& target : targets_)
      fs::remove_all(target.string() + kStagedEnding, error);
    for (std::size_t i = 0; i < archive_.files().size(); ++i) {
      const std::string& name = archive_.files()[i].name;
      if (!Takes(name)) continue;
      fs::path staged;
      (void)PlaceOf(name, options_.places, staged);
      INTAGLIO_TRY(archive_.Extract(i, staged));
    }
    if (!targets_.contains(options_.places.database)) return {};
    return history::AdaptRestoredQueue(
        options_.places.database.string() + kStagedEnding,
        {archive_.results(), fs::absolute(options_.places.results).string(),
         archive_.made_utc(), !options_.without.contains("jobs")});
  }

  Status Put() {
    std::string time = host::UtcText(std::chrono::system_clock::now());
    std::replace(time.begin(), time.end(), ':', '-');
    for (const fs::path& target : targets_) {
      for (const fs::path& file : FilesOf(target)) {
        std::error_code error;
        if (!fs::exists(file, error)) continue;
        const fs::path kept = file.string() + ".replaced-" + time;
        INTAGLIO_TRY(Rename(file, kept));
        kept_.push_back(kept);
      }
      INTAGLIO_TRY(Rename(target.string() + kStagedEnding, target));
    }
    return {};
  }

  Status Rename(const fs::path& from, const fs::path& to) {
    std::error_code error;
    fs::rename(from, to, error);
    if (error) {
      return Fail(ErrorCode::kIo,
                  fmt::format("cannot rename {} to {}: {}; check that its folder may be "
                              "written; nothing was changed",
                              from.string(), to.string(), error.message()),
                  from.string());
    }
    renamed_.emplace_back(from, to);
    return {};
  }

  const Archive& archive_;
  const RestoreOptions& options_;
  std::set<fs::path> targets_;
  std::vector<std::pair<fs::path, fs::path>> renamed_;  // from, to
  std::vector<fs::path> kept_;
};

}  // namespace

Result<std::vector<fs::path>> Restore(const Archive& archive,
                                      const RestoreOptions& options) {
  return Restoring(archive, options).Run();
}

}  // namespace intaglio::backup
