#include "services/cell/earlier_work.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"

namespace intaglio::cell {
namespace {

namespace fs = std::filesystem;
using formats::JournalKind;

Result<OpenedJournal> BeginJournal(const fs::path& file,
                                   const formats::JournalHeader& header) {
  auto writer = INTAGLIO_TRY(JournalWriter::Create(file, header));
  return OpenedJournal{std::move(writer), {}};
}

// Nothing fires before its intent is in the file.
bool HasNoPointRecords(const formats::Journal& journal) {
  return std::none_of(journal.records.begin(), journal.records.end(),
                      [](const auto& record) { return formats::IsOfPoint(record.kind); });
}

}  // namespace

EarlierWork EarlierWorkOf(const formats::Journal& journal) {
  EarlierWork earlier;
  earlier.damaged_records = journal.damaged_records;
  bool begun = false;
  std::uint32_t armed_run = 0;
  for (const formats::JournalRecord& record : journal.records) {
    // Nothing is armed before the session is: behind it records may have been lost.
    begun |= record.kind == JournalKind::kSession || formats::IsOfPoint(record.kind);
    earlier.highest_run = std::max(earlier.highest_run, record.run);
    switch (record.kind) {
      case JournalKind::kIntent:
        earlier.uncertain_unanswered = false;
        if (record.run > armed_run) ++earlier.run_count;
        armed_run = std::max(armed_run, record.run);
        break;
      case JournalKind::kOutcome:
        earlier.uncertain_unanswered |=
            record.outcome == formats::PointOutcome::kUncertain;
        break;
      case JournalKind::kSession:
        earlier.power_up = record.point;
        earlier.pulses_before_job = record.pulse_count;
        earlier.openings = record.openings;
        break;
      case JournalKind::kConsent:
      case JournalKind::kReopened:
        earlier.consent_grant = std::max(earlier.consent_grant, record.tick);
        break;
    }
  }
  if (begun) earlier.points = formats::HistoryOf(journal);
  return earlier;
}

Result<OpenedJournal> OpenJournal(const fs::path& file,
                                  const formats::JournalHeader& header, JobBegun begun) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error || size < formats::kJournalHeaderSize) {
    if (begun == JobBegun::kItsPathIsThere) {
      return Fail(
          ErrorCode::kUnreadable,
          fmt::format("{} is gone or cut to nothing, but the job was begun: nobody "
                      "knows what is in the block; check it, cancel the job, "
                      "and make it again on a new one (intaglio again)",
                      file.string()),
          file.string());
    }
    // A header that did not reach the disk whole was never followed by anything.
    fs::remove(file, error);
    return BeginJournal(file, header);
  }
  const auto journal = INTAGLIO_TRY(formats::ReadJournal(file));
  const bool same_path = journal.header.point_count == header.point_count &&
                         journal.header.path_crc == header.path_crc &&
                         journal.header.station == header.station;
  if (!same_path && !HasNoPointRecords(journal)) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{} has pulses of another path or station, of {}: "
                            "take the block out and cancel the job",
                            file.string(), Counted(journal.header.point_count, "point")),
                file.string());
  }
  if (!same_path) {
    fs::remove(file, error);
    return BeginJournal(file, header);
  }
  auto writer = INTAGLIO_TRY(JournalWriter::Continue(file));
  return OpenedJournal{std::move(writer), EarlierWorkOf(journal)};
}

}  // namespace intaglio::cell
