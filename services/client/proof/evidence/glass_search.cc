#include "services/client/proof/evidence/glass_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/formats/mark_record.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

bool IsKeptRecord(const fs::path& file) {
  return file.extension() == ".rec" && file.stem().string().starts_with("glass-");
}

/// By power-up. Files without a readable header are nobody's.
std::map<std::uint32_t, fs::path> RecordsIn(const fs::path& folder) {
  std::map<std::uint32_t, fs::path> records;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path& file = entry.path();
    if (file.filename() != kGlassRecord && !IsKeptRecord(file)) continue;
    const auto header = formats::ReadGlassHeader(file);
    if (header && header->power_up != 0) records[header->power_up] = file;
  }
  return records;
}

/// How many cracks a record may have.
std::size_t MaxCracks(const fs::path& record) {
  std::error_code no_size;  // Reading it gives the error.
  const std::uintmax_t size = fs::file_size(record, no_size);
  return no_size ? 0 : size / formats::kGlassRecordSize;
}

/// Those of the span, with ticks that are `offset` later. Unsigned: it may be negative,
/// and the sum is not.
Status AddOfSpan(const fs::path& record, const TickSpan& span, std::uint64_t offset,
                 JobGlass& glass) {
  const auto is_in = [&](std::uint64_t tick) {
    return tick >= span.first_tick && tick <= span.last_tick;
  };
  glass.Reserve(glass.cracks_mm.size() + MaxCracks(record));
  const auto read =
      INTAGLIO_TRY(formats::ReadGlassRecord(record, [&](formats::GlassCrack crack) {
        if (!is_in(crack.tick)) return;
        crack.tick += offset;
        glass.Add(crack);
      }));
  for (formats::GlassCollision collision : read.collisions) {
    if (!is_in(collision.tick)) continue;
    collision.tick += offset;
    glass.collisions.push_back(collision);
  }
  return {};
}

}  // namespace

void TickSpans::Receive(const formats::JournalRecord& record) {
  if (record.kind == formats::JournalKind::kSession) {
    EndSession();
    session_ = {record.point, record.tick, record.tick};
  } else if (record.kind == formats::JournalKind::kIntent) {
    tried_ = true;
    session_.last_tick = std::max(session_.last_tick, record.tick);
  }
}

void TickSpans::EndSession() {
  if (!std::exchange(tried_, false)) return;
  if (spans_.empty() || spans_.back().power_up != session_.power_up) {
    spans_.push_back(session_);
    return;
  }
  // An armed tick may lie behind the beginning of the next session.
  spans_.back().last_tick = std::max(spans_.back().last_tick, session_.last_tick);
}

std::vector<TickSpan> TickSpans::Finish() {
  EndSession();
  return std::move(spans_);
}

Result<std::vector<TickSpan>> ReadTickSpans(const fs::path& journal) {
  TickSpans spans;
  INTAGLIO_TRY(formats::ReadJournalRecords(
      journal, [&](const formats::JournalHeader&, const formats::JournalRecord& record) {
        spans.Receive(record);
      }));
  return spans.Finish();
}

void JobGlass::Reserve(std::size_t count) {
  cracks_mm.reserve(count);
  ticks.reserve(count);
  channels.reserve(count);
  stations.reserve(count);
}

void JobGlass::Add(const formats::GlassCrack& crack) {
  if (!crack.in_glass) return;
  cracks_mm.push_back(crack.position_mm);
  ticks.push_back(static_cast<double>(crack.tick));
  channels.push_back(crack.channel);
  stations.push_back(crack.station);
}

Result<JobGlass> AllGlass(const fs::path& record) {
  JobGlass glass;
  glass.Reserve(MaxCracks(record));
  auto read = INTAGLIO_TRY(formats::ReadGlassRecord(
      record, [&](const formats::GlassCrack& crack) { glass.Add(crack); }));
  glass.collisions = std::move(read.collisions);
  return glass;
}

Result<std::optional<JobGlass>> FindGlass(const std::vector<TickSpan>& spans,
                                          const fs::path& folder) {
  const auto records = RecordsIn(folder);
  JobGlass glass;
  std::uint64_t offset = 0, last_tick = 0;
  std::uint32_t power_up = 0;
  for (const TickSpan& span : spans) {
    const auto file = records.find(span.power_up);
    if (file == records.end()) return std::optional<JobGlass>();
    if (power_up != 0 && power_up != span.power_up)
      offset = last_tick + 1 - span.first_tick;
    power_up = span.power_up;
    last_tick = span.last_tick + offset;
    INTAGLIO_TRY(AddOfSpan(file->second, span, offset, glass));
  }
  return std::optional(std::move(glass));
}

namespace {

Status KeepRecord(const fs::path& record, const std::string& name) {
  const fs::path kept = record.parent_path() / name;
  std::error_code error;
  fs::rename(record, kept, error);
  if (!error) return {};
  return Fail(ErrorCode::kIo,
              fmt::format("cannot rename {} to {}: {}", record.string(), kept.string(),
                          error.message()),
              record.string());
}

}  // namespace

Status KeepGlassRecord(const fs::path& record) {
  const auto header = formats::ReadGlassHeader(record);
  // None, or one that belongs to no journal.
  if (!header || header->power_up == 0) return {};
  return KeepRecord(record, fmt::format("glass-{:08x}.rec", header->power_up));
}

Status KeepMarkRecord(const fs::path& record) {
  const auto header = formats::ReadMarkHeader(record);
  std::error_code error;
  // None, or one of a piece without marks.
  if (!header || fs::file_size(record, error) <= formats::kMarkHeaderSize) return {};
  return KeepRecord(record, fmt::format("marks-{:08x}.rec", header->power_up));
}

void RemoveGlassRecords(const fs::path& folder, const std::set<std::uint32_t>& needed) {
  for (const auto& [power_up, file] : RecordsIn(folder)) {
    std::error_code ignored;  // it stays, and is tried again at the next start
    if (IsKeptRecord(file) && !needed.contains(power_up)) fs::remove(file, ignored);
  }
}

}  // namespace intaglio::client
