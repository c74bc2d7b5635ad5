#include "services/console/cloud_reader.h"

#include <system_error>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/console/job_cloud.h"

namespace intaglio::console {
namespace {

constexpr std::uint64_t kMaxResultBytes = 64 << 20;
constexpr std::size_t kMaxPlanBytes = 64 << 20;

}  // namespace

bool CloudReader::AskForPlan(std::filesystem::path folder, Answer answer) {
  return queue_.Add([this, folder = std::move(folder), answer = std::move(answer)] {
    answer(Plan(folder));
  });
}

bool CloudReader::IsPart(std::string_view name) {
  return name == "made" || name == "ticks" || name == "channels";
}

bool CloudReader::AskForPart(std::string name, std::filesystem::path folder,
                             std::uint32_t from, Answer answer) {
  return queue_.Add([name = std::move(name), folder = std::move(folder), from,
                     answer = std::move(answer)] {
    auto part = name == "channels" ? ReadChannels(folder)
                : name == "ticks"  ? ReadTicks(folder, from)
                                   : ReadMade(folder, from);
    if (!part) return answer(tl::unexpected(part.error()));
    answer(std::make_shared<const std::string>(std::move(*part)));
  });
}

bool CloudReader::AskForFile(std::filesystem::path file, Answer answer) {
  return queue_.Add([file = std::move(file), answer = std::move(answer)] {
    auto bytes = io::ReadWholeFile(file, kMaxResultBytes);
    if (!bytes) return answer(tl::unexpected(bytes.error()));
    answer(std::make_shared<const std::string>(std::move(*bytes)));
  });
}

Result<CloudReader::Bytes> CloudReader::Plan(const std::filesystem::path& folder) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(folder / "path.ply", error);
  for (const Sent& sent : sent_) {
    Bytes bytes = sent.bytes.lock();
    if (!error && bytes && sent.folder == folder && sent.written == written)
      return kept_ = std::move(bytes);
  }
  const std::size_t wanted = INTAGLIO_TRY(PlanBytes(folder));
  kept_ = nullptr;
  std::erase_if(sent_, [](const Sent& sent) { return sent.bytes.expired(); });
  std::size_t busy = 0;
  for (const Sent& sent : sent_) {
    if (const Bytes bytes = sent.bytes.lock()) busy += bytes->size();
  }
  if (busy > 0 && busy + wanted > kMaxPlanBytes)
    return Fail(ErrorCode::kRefused, "plans of other jobs are being sent: try again");
  kept_ = std::make_shared<const std::string>(INTAGLIO_TRY(ReadPlan(folder)));
  sent_.push_back({folder, written, kept_});
  return kept_;
}

}  // namespace intaglio::console
