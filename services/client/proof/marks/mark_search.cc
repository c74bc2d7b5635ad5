#include "services/client/proof/marks/mark_search.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/client/proof/evidence/glass_search.h"
#include "services/platform/link/scan_head_protocol.h"
#include "services/virtual_engraver/truth/truth_file.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using formats::JournalKind;
using formats::JournalRecord;

constexpr char kTruthFile[] = "truth.textproto";

bool IsKeptMarkRecord(const fs::path& file) {
  return file.extension() == ".rec" && file.stem().string().starts_with("marks-");
}

std::set<std::string> SerialNumbersIn(const fs::path& folder, const std::string& own) {
  std::set<std::string> numbers = {own};
  if (const auto truth = ReadTruthFile(folder / kTruthFile))
    numbers.insert(truth->head().serial_number());
  return numbers;
}

/// The job's runs in each power-up, and the power-ups in the order of the journal.
struct RunsOf {
  std::vector<std::uint32_t> power_ups;
  std::map<std::uint32_t, std::set<std::uint32_t>> runs;
};

RunsOf RunsIn(const formats::Journal& journal) {
  RunsOf of;
  std::uint32_t power_up = 0;
  for (const JournalRecord& record : journal.records) {
    if (record.kind == JournalKind::kSession) power_up = record.point;
    if (record.kind != JournalKind::kIntent) continue;
    if (of.runs[power_up].empty()) of.power_ups.push_back(power_up);
    of.runs[power_up].insert(record.run);
  }
  return of;
}

// Farther than this from all that was burnt no print mark is that of a repeat.
constexpr double kPrintsAroundMm = 10000;

struct AlongWeb {
  double from_mm = 0, to_mm = 0;
};

AlongWeb ExtentOf(const std::vector<formats::BurntTick>& ticks) {
  const auto [low, high] = std::ranges::minmax_element(
      ticks, {}, [](const formats::BurntTick& tick) { return tick.place_mm.x(); });
  return {low->place_mm.x() - kPrintsAroundMm, high->place_mm.x() + kPrintsAroundMm};
}

/// Without those that are of no use, in a shop that runs for days.
void KeepPrints(formats::MarkRecord& record) {
  if (record.ticks.empty()) return record.prints.clear();
  const AlongWeb around = ExtentOf(record.ticks);
  std::erase_if(record.prints, [&](const formats::PrintMark& mark) {
    return mark.place_mm < around.from_mm || mark.place_mm > around.to_mm;
  });
}

/// The web of a later power-up is another one: it is laid behind the one before.
void LayBehind(const formats::MarkRecord& before, formats::MarkRecord& record) {
  if (record.prints.empty() || before.ticks.empty()) return;
  const double by_mm = ExtentOf(before.ticks).from_mm - ExtentOf(record.ticks).to_mm;
  for (formats::BurntTick& tick : record.ticks) tick.place_mm.x() += by_mm;
  for (formats::PrintMark& mark : record.prints) mark.place_mm += by_mm;
}

/// Keeps the ticks of these runs, and leaves out the others.
void KeepTicks(const std::set<std::uint32_t>& runs,
               std::vector<formats::BurntTick>& ticks) {
  const auto is_own = [&](const formats::BurntTick& tick) {
    return runs.contains(tick.run);
  };
  const auto first = std::find_if(ticks.begin(), ticks.end(), is_own);
  const auto behind = std::find_if(ticks.rbegin(), ticks.rend(), is_own).base();
  if (first == ticks.end()) return ticks.clear();
  ticks.erase(behind, ticks.end());
  ticks.erase(ticks.begin(), first);
  for (formats::BurntTick& tick : ticks)
    if (!is_own(tick)) tick.mark = kNoMark;
}

}  // namespace

std::map<std::uint32_t, fs::path> MarkRecordsIn(const fs::path& folder,
                                                const std::string& serial_number) {
  const auto serial_numbers = SerialNumbersIn(folder, serial_number);
  std::map<std::uint32_t, fs::path> records;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path& file = entry.path();
    if (file.filename() != kMarkRecord && !IsKeptMarkRecord(file)) continue;
    const auto header = formats::ReadMarkHeader(file);
    if (!header) continue;
    for (const std::string& number : serial_numbers) {
      records[formats::PowerUpOfText(link::HeadPowerUpText(number, header->power_up))] =
          file;
    }
  }
  return records;
}

Result<std::optional<formats::MarkRecord>> FindBurnt(
    const formats::Journal& journal, const std::map<std::uint32_t, fs::path>& records) {
  const RunsOf of = RunsIn(journal);
  std::optional<formats::MarkRecord> found(std::in_place);
  for (const std::uint32_t power_up : of.power_ups) {
    const auto file = records.find(power_up);
    if (file == records.end()) return std::optional<formats::MarkRecord>();
    auto record = INTAGLIO_TRY(formats::ReadMarkRecord(file->second));
    KeepTicks(of.runs.at(power_up), record.ticks);
    if (found->header.field_mm == 0) found->header = record.header;
    if (record.ticks.empty()) continue;
    KeepPrints(record);
    LayBehind(*found, record);
    // Unsigned: the offset may be negative, and the sum is not.
    const std::uint64_t offset =
        found->ticks.empty() ? 0
                             : found->ticks.back().tick + 1 - record.ticks.front().tick;
    for (formats::BurntTick& tick : record.ticks) {
      tick.tick += offset;
      found->ticks.push_back(tick);
    }
    for (formats::PrintMark& mark : record.prints) {
      mark.tick += offset;
      found->prints.push_back(mark);
    }
  }
  return found;
}

Result<formats::MarkRecord> AllBurnt(const formats::Journal& journal,
                                     const fs::path& file) {
  std::set<std::uint32_t> own;
  for (const auto& [power_up, runs] : RunsIn(journal).runs)
    own.insert(runs.begin(), runs.end());
  auto record = INTAGLIO_TRY(formats::ReadMarkRecord(file));
  for (formats::BurntTick& tick : record.ticks)
    if (!own.contains(tick.run)) tick.mark = kNoMark;
  record.torn_bytes = 0;
  return record;
}

void RemoveMarkRecords(const fs::path& folder, const std::set<std::uint32_t>& needed) {
  std::set<fs::path> kept;
  const auto records = MarkRecordsIn(folder, "");
  for (const auto& [power_up, file] : records)
    if (needed.contains(power_up)) kept.insert(file);
  for (const auto& [power_up, file] : records) {
    std::error_code ignored;  // it stays, and is tried again at the next start
    if (IsKeptMarkRecord(file) && !kept.contains(file)) fs::remove(file, ignored);
  }
}

}  // namespace intaglio::client
