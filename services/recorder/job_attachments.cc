#include "services/recorder/job_attachments.h"

#include <google/protobuf/text_format.h>

#include <span>

#include "proto/task.pb.h"
#include "services/platform/bus/samples.h"

namespace intaglio::recorder {
namespace {

// More than there are workers, each of which has one task.
constexpr std::size_t kKnownJobs = 1024;

recording::Attachment Attachment(const std::string& folder, const std::string& name,
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

std::vector<recording::Attachment> AttachmentsOf(recording::ByteView frozen_job,
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
  return {
      Attachment(folder, "job.textproto", kText, TextOf(job.job()), now_ns),
      Attachment(folder, "machine.textproto", kText, TextOf(job.machine()), now_ns),
      Attachment(folder, "material.textproto", kText, TextOf(job.material()), now_ns),
      Attachment(folder, "software_version.txt", kText, job.software_version(), now_ns),
      Attachment(folder, "frozen_job.binpb", "application/x-protobuf", raw, now_ns)};
}

JobAttachments::JobAttachments(bus::Bus& bus)
    : discretize_(bus, bus::kDiscretizeTask),
      sort_(bus, bus::kSortTask),
      engrave_(bus, bus::kEngraveTask) {}

std::vector<recording::Attachment> JobAttachments::Take(std::uint64_t now_ns) {
  std::vector<recording::Attachment> attachments;
  const auto period = [&](const intaglio_StageTask& task) {
    const auto frozen = bus::View(task.frozen_job);
    std::string uid(bus::View(task.job_uid));
    if (frozen.empty() || !known_.insert(uid).second) return;
    by_age_.push_back(std::move(uid));
    if (by_age_.size() > kKnownJobs) {
      known_.erase(by_age_.front());
      by_age_.pop_front();
    }
    auto made = AttachmentsOf(std::as_bytes(frozen), now_ns);
    std::move(made.begin(), made.end(), std::back_inserter(attachments));
  };
  for (auto* reader : {&discretize_, &sort_, &engrave_}) reader->Take(period);
  return attachments;
}

}  // namespace intaglio::recorder
