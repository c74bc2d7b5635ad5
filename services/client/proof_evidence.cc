#include "services/client/proof_evidence.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include "engrave/formats/point_file.h"
#include "engrave/io/whole_file.h"
#include "services/job/channels.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

// A job with its machine and glass is a few kilobytes.
constexpr std::uint64_t kMaxTextBytes = 16 << 20;

Result<FrozenJob> ReadFrozenJob(const fs::path& file) {
  const auto text = io::ReadWholeFile(file, kMaxTextBytes);
  if (!text) return tl::unexpected(text.error());
  FrozenJob job;
  const auto parsed = google::protobuf::util::JsonStringToMessage(*text, &job);
  if (!parsed.ok()) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{} does not contain a frozen job: {}", file.string(),
                            parsed.ToString()));
  }
  return job;
}

template <typename Value>
Result<const std::vector<Value>*> ColumnOf(const formats::PointTable& table,
                                           const char* name, const fs::path& file) {
  const auto* column = table.Find<Value>(name);
  if (column == nullptr) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{} has no column '{}'", file.string(), name));
  }
  return column;
}

}  // namespace

Result<Evidence> ReadEvidence(const fs::path& folder) {
  Evidence evidence;
  auto job = ReadFrozenJob(folder / "job.json");
  if (!job) return tl::unexpected(job.error());
  evidence.job = std::move(*job);
  auto plan = formats::ReadPly(folder / "path.ply");
  if (!plan) return tl::unexpected(plan.error());
  const auto source = ColumnOf<std::uint32_t>(*plan, "source", folder / "path.ply");
  if (!source) return tl::unexpected(source.error());
  auto masks = ChannelsOfPoints(evidence.job.job(), **source);
  if (!masks) return tl::unexpected(masks.error());
  evidence.masks = std::move(*masks);
  evidence.plan_mm = std::move(plan->points_mm);
  const auto glass = formats::ReadPly(folder / "glass.ply");
  if (!glass) return tl::unexpected(glass.error());
  const auto tick = ColumnOf<double>(*glass, "tick", folder / "glass.ply");
  if (!tick) return tl::unexpected(tick.error());
  const auto channel = ColumnOf<std::uint8_t>(*glass, "channel", folder / "glass.ply");
  if (!channel) return tl::unexpected(channel.error());
  for (std::size_t i = 0; i < glass->points_mm.size(); ++i) {
    const std::uint8_t number = (**channel)[i];
    if (number >= kMaxChannels) {
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("{}: crack {} is in channel {}, of 0..{}",
                      (folder / "glass.ply").string(), i, number, kMaxChannels - 1));
    }
    evidence.cracks.push_back({glass->points_mm[i],
                               static_cast<std::uint64_t>((**tick)[i]),
                               MaskOfChannel(number + 1u)});
  }
  const auto journal = formats::ReadJournal(folder / "journal.bin");
  if (!journal) return tl::unexpected(journal.error());
  evidence.history = formats::HistoryOf(*journal);
  evidence.history.resize(evidence.plan_mm.size());
  return evidence;
}

}  // namespace intaglio::client
