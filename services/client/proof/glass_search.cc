#include "services/client/proof/glass_search.h"

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

/// Those of the span, with ticks that are `offset` later. Unsigned: it may be negative,
/// and the sum is not.
template <typename Record>
void AddOfSpan(const std::vector<Record>& all, const TickSpan& span, std::uint64_t offset,
               std::vector<Record>& into) {
  for (Record record : all) {
    if (record.tick < span.first_tick || record.tick > span.last_tick) continue;
    record.tick += offset;
    into.push_back(record);
  }
}

}  // namespace

void TickSpans::Take(const formats::JournalRecord& record) {
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
        spans.Take(record);
      }));
  return spans.Finish();
}

Result<std::optional<JobGlass>> FindGlass(const std::vector<TickSpan>& spans,
                                          const fs::path& folder) {
  const auto records = RecordsIn(folder);
  std::map<std::uint32_t, formats::GlassRecord> read;
  JobGlass glass;
  std::uint64_t offset = 0, last_tick = 0;
  std::uint32_t power_up = 0;
  for (const TickSpan& span : spans) {
    const auto file = records.find(span.power_up);
    if (file == records.end()) return std::optional<JobGlass>();
    if (!read.contains(span.power_up)) {
      auto record = INTAGLIO_TRY(formats::ReadGlassRecord(file->second));
      read.emplace(span.power_up, std::move(record));
    }
    if (power_up != 0 && power_up != span.power_up)
      offset = last_tick + 1 - span.first_tick;
    power_up = span.power_up;
    last_tick = span.last_tick + offset;
    AddOfSpan(read.at(span.power_up).cracks, span, offset, glass.cracks);
    AddOfSpan(read.at(span.power_up).collisions, span, offset, glass.collisions);
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
