// Any bytes as a journal: its whole records or an error with a message. The same
// bytes as the fields of a journal, whose checksums hold: what is read and written again
// reads the same, and the history of its points stays in bounds.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "engrave/formats/journal_file.h"

namespace {

using namespace intaglio::formats;

// A history takes about 40 bytes per point, whatever the journal's size.
constexpr std::uint64_t kMaxPointsHere = 1'000'000;

std::vector<std::byte> Written(const JournalHeader& header,
                               std::span<const JournalRecord> records) {
  const auto head = EncodeJournalHeader(header);
  std::vector<std::byte> bytes(head.begin(), head.end());
  for (const JournalRecord& record : records) {
    const auto encoded = EncodeJournalRecord(record);
    bytes.insert(bytes.end(), encoded.begin(), encoded.end());
  }
  return bytes;
}

void Try(std::span<const std::byte> bytes) {
  const auto journal = ParseJournal(bytes);
  if (!journal) {
    if (journal.error().message.empty()) std::abort();
    return;
  }
  const std::size_t records = journal->records.size() + journal->damaged_records;
  if (kJournalHeaderSize + records * kJournalRecordSize + journal->torn_bytes !=
      bytes.size()) {
    std::abort();
  }
  const auto again = ParseJournal(Written(journal->header, journal->records));
  if (!again || again->records != journal->records || again->torn_bytes != 0 ||
      again->header != journal->header || again->damaged_records != 0) {
    std::abort();
  }
  if (journal->header.point_count > kMaxPointsHere) return;
  if (HistoryOf(*journal).size() != journal->header.point_count) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  Try(std::as_bytes(std::span(bytes, size)));
  if (size < 8) return 0;
  JournalHeader header;
  std::memcpy(&header.point_count, bytes, 8);
  std::vector<JournalRecord> records;
  constexpr std::size_t kFields = 11;
  for (std::size_t at = 8; at + kFields <= size; at += kFields) {
    JournalRecord record;
    record.kind = static_cast<JournalKind>(bytes[at]);
    record.outcome = static_cast<PointOutcome>(bytes[at + 1]);
    record.reason = bytes[at + 2];
    std::memcpy(&record.point, bytes + at + 3, 4);
    std::memcpy(&record.tick, bytes + at + 7, 4);
    record.missed_channels = record.reason;
    std::memcpy(&record.measured_mj, bytes + at + 7, 4);
    records.push_back(record);
  }
  Try(Written(header, records));
  return 0;
}
