#include "services/recorder/job_papers.h"

#include <google/protobuf/text_format.h>

#include <span>

#include "proto/task.pb.h"
#include "services/platform/bus/samples.h"

namespace intaglio::recorder {
namespace {

// More than there are workers, each of which has one task.
constexpr std::size_t kKnownJobs = 1024;

recording::Attachment Paper(const std::string& folder, const std::string& name,
                            const char* media_type, std::string_view content,
                            std::uint64_t now_ns) {
  const auto bytes = std::as_bytes(std::span(content));
  return {now_ns, now_ns, folder + name, media_type, {bytes.begin(), bytes.end()}};
}

std::string TextOf(const google::protobuf::Message& message) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(message, &text);
  return text;
}

}  // namespace

std::vector<recording::Attachment> PapersOf(recording::ByteView frozen_job,
                                            std::uint64_t now_ns) {
  FrozenJob job;
  if (!job.ParseFromArray(frozen_job.data(), static_cast<int>(frozen_job.size())) ||
      job.job_uid().empty()) {
    return {};
  }
  const std::string folder = "jobs/" + job.job_uid() + "/";
  constexpr char kText[] = "text/plain";
  const std::string_view raw(reinterpret_cast<const char*>(frozen_job.data()),
                             frozen_job.size());
  return {Paper(folder, "job.textproto", kText, TextOf(job.job()), now_ns),
          Paper(folder, "machine.textproto", kText, TextOf(job.machine()), now_ns),
          Paper(folder, "material.textproto", kText, TextOf(job.material()), now_ns),
          Paper(folder, "software_version.txt", kText, job.software_version(), now_ns),
          Paper(folder, "frozen_job.binpb", "application/x-protobuf", raw, now_ns)};
}

JobPapers::JobPapers(bus::Bus& bus)
    : discretize_(bus, bus::kDiscretizeTask),
      sort_(bus, bus::kSortTask),
      engrave_(bus, bus::kEngraveTask) {}

std::vector<recording::Attachment> JobPapers::Take(std::uint64_t now_ns) {
  std::vector<recording::Attachment> papers;
  const auto look = [&](const intaglio_StageTask& task) {
    const auto frozen = bus::View(task.frozen_job);
    std::string uid(bus::View(task.job_uid));
    if (frozen.empty() || !known_.insert(uid).second) return;
    by_age_.push_back(std::move(uid));
    if (by_age_.size() > kKnownJobs) {
      known_.erase(by_age_.front());
      by_age_.pop_front();
    }
    auto made = PapersOf(std::as_bytes(frozen), now_ns);
    std::move(made.begin(), made.end(), std::back_inserter(papers));
  };
  for (auto* reader : {&discretize_, &sort_, &engrave_}) reader->Take(look);
  return papers;
}

}  // namespace intaglio::recorder
