#include "services/client/proof/evidence/proof_evidence.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/whole_file.h"
#include "services/client/proof/evidence/collisions.h"
#include "services/client/proof/evidence/glass_search.h"
#include "services/job/beams/energy_by_place.h"
#include "services/job/fields/channels.h"
#include "services/platform/host/process/freed_memory.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

// A job with its machine and glass is a few kilobytes.
constexpr std::uint64_t kMaxTextBytes = 16 << 20;

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

Status CheckChannels(const fs::path& file, const std::vector<std::uint8_t>& channels) {
  const auto wrong = std::ranges::find_if(
      channels, [](std::uint8_t number) { return number >= kMaxChannels; });
  if (wrong == channels.end()) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{}: crack {} is in channel {}, of 0..{}", file.string(),
                          wrong - channels.begin(), *wrong, kMaxChannels - 1));
}

/// Leaves those of the values whose crack is in the station, in their order.
template <typename Value>
void KeepOfStation(const std::vector<std::uint8_t>& stations, std::uint32_t own,
                   std::vector<Value>& values) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (stations[i] == own) values[kept++] = values[i];
  }
  values.resize(kept);
}

/// Cracks and cracks_elsewhere_count of the evidence.
Status ReadCracks(const fs::path& file, Evidence& evidence) {
  auto glass = INTAGLIO_TRY(formats::ReadPly(file));
  const auto tick = INTAGLIO_TRY(ColumnOf<double>(glass, "tick", file));
  const auto channel = INTAGLIO_TRY(ColumnOf<std::uint8_t>(glass, "channel", file));
  INTAGLIO_TRY(CheckChannels(file, *channel));
  proof::Cracks& cracks = evidence.cracks;
  cracks.positions_mm = std::move(glass.points_mm);
  cracks.ticks.assign(tick->begin(), tick->end());
  cracks.channels.reserve(channel->size());
  for (const std::uint8_t number : *channel)
    cracks.channels.push_back(MaskOfChannel(number + 1u));
  // A folder that was completed before there were stations has none.
  const auto* station = glass.Find<std::uint8_t>("station");
  if (station == nullptr) return {};
  const std::uint32_t own = std::max(1u, evidence.job.job().station());
  KeepOfStation(*station, own, cracks.positions_mm);
  KeepOfStation(*station, own, cracks.ticks);
  KeepOfStation(*station, own, cracks.channels);
  evidence.cracks_elsewhere_count = station->size() - cracks.size();
  return {};
}

/// The plan's points, and what follows from the models that they are of.
Status ReadPlan(const fs::path& file, Evidence& evidence) {
  auto plan = INTAGLIO_TRY(formats::ReadPly(file));
  const auto source = INTAGLIO_TRY(ColumnOf<std::uint32_t>(plan, "source", file));
  auto masks = INTAGLIO_TRY(ChannelsOfPoints(evidence.job.job(), *source));
  evidence.masks = std::move(masks);
  auto energies = INTAGLIO_TRY(EnergiesOfPoints(evidence.job, plan.points_mm, *source));
  evidence.energies = std::move(energies);
  evidence.plan_mm = std::move(plan.points_mm);
  return {};
}

/// What the journal has of the plan's points, and its power-ups.
Status ReadPulses(const fs::path& file, Evidence& evidence) {
  formats::PointHistories histories;
  TickSpans spans;
  const auto header = INTAGLIO_TRY(formats::ReadJournalRecords(
      file, [&](const formats::JournalHeader& of, const formats::JournalRecord& record) {
        histories.Receive(of, record);
        spans.Receive(record);
      }));
  evidence.history = histories.Finish(header);
  evidence.history.resize(evidence.plan_mm.size());
  for (const TickSpan& span : spans.Finish()) evidence.power_ups.push_back(span.power_up);
  return {};
}

}  // namespace

Result<FrozenJob> ReadFrozenJob(const fs::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxTextBytes));
  FrozenJob job;
  const auto parsed = google::protobuf::util::JsonStringToMessage(text, &job);
  if (!parsed.ok()) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{} does not contain a frozen job: {}", file.string(),
                            parsed.ToString()));
  }
  return job;
}

Result<Evidence> ReadEvidence(const fs::path& folder) {
  Evidence evidence;
  host::ReturnFreedMemory();
  auto job = INTAGLIO_TRY(ReadFrozenJob(folder / "job.json"));
  evidence.job = std::move(job);
  INTAGLIO_TRY(ReadPlan(folder / "path.ply", evidence));
  host::ReturnFreedMemory();
  if (fs::exists(folder / "glass.ply")) {
    INTAGLIO_TRY(ReadCracks(folder / "glass.ply", evidence));
    evidence.has_glass = true;
    auto collisions = INTAGLIO_TRY(ReadCollisions(folder));
    evidence.collisions = std::move(collisions);
    host::ReturnFreedMemory();
  }
  INTAGLIO_TRY(ReadPulses(folder / "journal.bin", evidence));
  return evidence;
}

}  // namespace intaglio::client
