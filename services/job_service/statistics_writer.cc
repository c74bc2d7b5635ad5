#include "services/job_service/statistics_writer.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "services/job/files/json_text.h"
#include "services/platform/host/process/log.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "statistics.json";

/// The first file of the folder with this ending, by name; empty when there is none.
std::string FindFile(const fs::path& folder, const std::string& ending) {
  std::string found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string path = entry.path().string();
    if (path.ends_with(ending) && (found.empty() || path < found)) found = path;
  }
  return found;
}

Status WriteStatistics(const JobStatistics& statistics) {
  const fs::path folder = statistics.result_directory();
  std::error_code ignored;  // the write reports the error
  fs::create_directories(folder, ignored);
  const auto json = INTAGLIO_TRY(JsonTextOf(statistics));
  return io::WriteFileAtomically(folder / kFile, json);
}

}  // namespace

StatisticsWriter::StatisticsWriter(JobStore& store, std::string recording)
    : store_(store),
      recording_(std::move(recording)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

StatisticsWriter::~StatisticsWriter() {
  thread_.request_stop();
  thread_.join();
}

void StatisticsWriter::Changed(const JobRecord& job) { Write(job); }

void StatisticsWriter::Progressed(const JobRecord& job) {
  if (job.ended()) return;
  const auto last = written_.find(job.uid);
  if (last != written_.end() &&
      std::chrono::steady_clock::now() - last->second < kPeriod) {
    return;
  }
  Write(job);
}

void StatisticsWriter::Ended(const JobRecord& job, bool more_is_expected) {
  const fs::path folder = job.result_directory;
  std::string report = FindFile(folder, "/report.json");
  if (report.empty()) report = (folder / kFile).string();
  std::string recording = FindFile(folder, ".mcap");
  if (recording.empty()) recording = recording_;
  store_.KeepVerdict(job.uid, report, recording, {job.counts, !more_is_expected});
  Write(job);
  written_.erase(job.uid);
}

void StatisticsWriter::Write(const JobRecord& job) {
  written_[job.uid] = std::chrono::steady_clock::now();
  JobStatistics statistics = store_.StatisticsOf(job, std::chrono::system_clock::now());
  const std::lock_guard lock(mutex_);
  waiting_[job.uid] = std::move(statistics);
  wake_.notify_one();
}

void StatisticsWriter::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !waiting_.empty(); })) {
    const auto taken = std::exchange(waiting_, {});
    lock.unlock();
    for (const auto& [uid, statistics] : taken) {
      if (auto written = WriteStatistics(statistics); !written) {
        host::LogWarning("statistics of job {}: {}", uid, written.error().message);
      }
    }
    lock.lock();
  }
}

}  // namespace intaglio::job_service
