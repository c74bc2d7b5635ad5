#include "services/client/shop/job_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <string_view>
#include <utility>

#include "engrave/core/try.h"
#include "services/client/shop/shop_cells.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTimeLength = std::string_view("2026-11-26T23:28:37.346").size();
constexpr std::size_t kMaxEntryBytes = 64 * 1024;

/// Whether an entry begins with this line: others belong to the entry above.
bool BeginsEntry(std::string_view line) {
  return line.size() > kTimeLength && line[kTimeLength] == ' ' &&
         host::HasShapeOfUtc(line.substr(0, kTimeLength));
}

/// "job 12-6b08c0a52033" for 12 and for the uid itself, but not for 1 or 6b.
bool IsAbout(std::string_view entry, std::string_view job) {
  constexpr std::string_view kJob = "job ";
  for (std::size_t at = entry.find(kJob); at != entry.npos;
       at = entry.find(kJob, at + 1)) {
    std::string_view named = entry.substr(at + kJob.size());
    if (!named.starts_with(job)) continue;
    named.remove_prefix(job.size());
    if (named.empty() || named.front() == '-' ||
        std::isalnum(static_cast<unsigned char>(named.front())) == 0) {
      return true;
    }
  }
  return false;
}

bool IsWarning(std::string_view entry) {
  const std::size_t service = entry.find(' ', kTimeLength + 1);
  if (service == entry.npos) return false;
  const std::string_view level = entry.substr(service + 1);
  return level.starts_with("warning:") || level.starts_with("error:") ||
         level.starts_with("critical:");
}

/// Keeps the newest entries that are asked for.
class Chosen {
 public:
  explicit Chosen(const LogSelection& selection) : selection_(selection) {}

  void Add(std::string entry) {
    if (entry.empty() || (selection_.warnings_only && !IsWarning(entry)) ||
        (!selection_.job.empty() && !IsAbout(entry, selection_.job))) {
      return;
    }
    entries_.push_back(std::move(entry));
    if (entries_.size() > 2 * selection_.max_count + 1000) KeepNewest();
  }

  std::vector<std::string> Take() {
    KeepNewest();
    return std::move(entries_);
  }

 private:
  void KeepNewest() {
    std::ranges::stable_sort(entries_, {}, [](const std::string& entry) {
      return std::string_view(entry).substr(0, kTimeLength);
    });
    if (entries_.size() <= selection_.max_count) return;
    entries_.erase(entries_.begin(),
                   entries_.end() - static_cast<std::ptrdiff_t>(selection_.max_count));
  }

  const LogSelection& selection_;
  std::vector<std::string> entries_;
};

Status AddFile(const fs::path& file, Chosen& chosen) {
  std::ifstream in(file);
  if (!in) {
    return Fail(ErrorCode::kIo,
                fmt::format("{}: cannot be read: check its permissions", file.string()),
                file.string());
  }
  std::string entry;
  for (std::string line; std::getline(in, line);) {
    if (BeginsEntry(line)) {
      chosen.Add(std::exchange(entry, std::move(line)));
    } else if (!entry.empty() && entry.size() + line.size() < kMaxEntryBytes) {
      entry += "\n" + line;
    }
  }
  chosen.Add(std::move(entry));
  return {};
}

void AddLogsIn(const fs::path& folder, std::vector<fs::path>& files) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".log") files.push_back(entry.path());
  }
}

}  // namespace

Result<std::vector<std::string>> ReadLog(const fs::path& folder,
                                         const LogSelection& selection) {
  std::vector<fs::path> files;
  AddLogsIn(folder, files);
  std::error_code error;
  for (const auto& cell : fs::directory_iterator(folder / kCellsFolder, error)) {
    AddLogsIn(cell.path(), files);
  }
  if (files.empty()) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{}: holds no logs; give the folder of `intaglio up` or of a "
                            "run's session with --folder. Services that systemd has "
                            "started log to its journal: journalctl -u 'intaglio-*'",
                            folder.string()),
                folder.string());
  }
  std::ranges::sort(files);
  Chosen chosen(selection);
  for (const fs::path& file : files) INTAGLIO_TRY(AddFile(file, chosen));
  return chosen.Take();
}

LogEntry LogEntryOf(const std::string& entry) {
  LogEntry parts;
  const std::size_t service = kTimeLength + 1;
  const std::size_t level = entry.find(' ', service);
  const std::size_t text = level == entry.npos ? level : entry.find(": ", level);
  if (!BeginsEntry(entry) || text == entry.npos) {
    parts.set_text(entry);
    return parts;
  }
  parts.set_time(entry.substr(0, kTimeLength));
  parts.set_service(entry.substr(service, level - service));
  parts.set_level(entry.substr(level + 1, text - level - 1));
  parts.set_text(entry.substr(text + 2));
  return parts;
}

}  // namespace intaglio::client
