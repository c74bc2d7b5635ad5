#include "engrave/formats/journal_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/formats/record_file.h"
#include "engrave/io/crc32.h"

namespace intaglio::formats {
namespace {

constexpr RecordKind kJournal{"INTJRNL1", "engraving journal", 2,
                              2,          kJournalHeaderSize,  kJournalRecordSize};
constexpr std::uint64_t kMaxJournalFile = std::uint64_t{1} << 36;
// A record's point must not make the reader allocate without bound.
constexpr std::uint64_t kMaxPoints = 100'000'000;

std::optional<JournalRecord> DecodeRecord(std::span<const std::byte> bytes,
                                          const JournalHeader& header) {
  const auto kind = static_cast<JournalKind>(bytes[0]);
  const bool of_point = IsOfPoint(kind);
  const bool known =
      of_point || kind == JournalKind::kSession || kind == JournalKind::kConsent;
  const auto point = NumberAt<std::uint32_t>(bytes.data() + 16);
  if (!IsSealed(bytes) || !known || (of_point && point >= header.point_count) ||
      bytes[1] > static_cast<std::byte>(PointOutcome::kLeftOut)) {
    return std::nullopt;
  }
  JournalRecord record{kind,
                       static_cast<PointOutcome>(bytes[1]),
                       static_cast<std::uint8_t>(bytes[2]),
                       NumberAt<std::uint32_t>(bytes.data() + 4),
                       NumberAt<std::uint64_t>(bytes.data() + 8),
                       point,
                       NumberAt<std::uint32_t>(bytes.data() + 24)};
  const auto extra = NumberAt<std::uint32_t>(bytes.data() + 20);
  if (kind != JournalKind::kOutcome) {
    record.openings = extra;
  } else {
    record.missed_channels = static_cast<std::uint8_t>(bytes[3]);
    const auto energy_mj = std::bit_cast<float>(extra);
    if (std::isfinite(energy_mj) && energy_mj > 0) record.measured_mj = energy_mj;
  }
  return record;
}

}  // namespace

std::array<std::byte, kJournalHeaderSize> EncodeJournalHeader(
    const JournalHeader& header) {
  std::array<std::byte, kJournalHeaderSize> bytes{};
  std::ranges::copy(NewRecordHeader(kJournal), bytes.begin());
  PutNumber<std::uint64_t>(bytes.data() + 16, header.point_count);
  PutNumber<std::uint64_t>(bytes.data() + 24, header.epoch);
  PutNumber<std::uint32_t>(bytes.data() + 32, header.path_crc);
  PutNumber<std::uint32_t>(bytes.data() + 36, header.station);
  Seal(bytes);
  return bytes;
}

std::array<std::byte, kJournalRecordSize> EncodeJournalRecord(
    const JournalRecord& record) {
  std::array<std::byte, kJournalRecordSize> bytes{};
  bytes[0] = static_cast<std::byte>(record.kind);
  bytes[1] = static_cast<std::byte>(record.outcome);
  bytes[2] = static_cast<std::byte>(record.reason);
  PutNumber<std::uint32_t>(bytes.data() + 4, record.run);
  PutNumber<std::uint64_t>(bytes.data() + 8, record.tick);
  PutNumber<std::uint32_t>(bytes.data() + 16, record.point);
  const bool has_outcome = record.kind == JournalKind::kOutcome;
  if (has_outcome) bytes[3] = static_cast<std::byte>(record.missed_channels);
  PutNumber<std::uint32_t>(
      bytes.data() + 20,
      has_outcome ? std::bit_cast<std::uint32_t>(record.measured_mj) : record.openings);
  PutNumber<std::uint32_t>(bytes.data() + 24, record.pulse_count);
  Seal(bytes);
  return bytes;
}

namespace {

/// The records of a journal from its bytes in pieces of whole records, the first with the
/// header.
class JournalReader {
 public:
  explicit JournalReader(const TakeJournalRecord& take) : take_(take) {}

  Status Receive(std::span<const std::byte> bytes) {
    if (taken_ == 0) {
      INTAGLIO_TRY(TakeHeader(bytes));
      taken_ = behind_last_ = kJournalHeaderSize;
      bytes = bytes.subspan(kJournalHeaderSize);
    }
    for (; bytes.size() >= kJournalRecordSize; bytes = bytes.subspan(kJournalRecordSize))
      TakeRecord(bytes.first(kJournalRecordSize));
    taken_ += bytes.size();
    return {};
  }
  const JournalHeader& header() const { return header_; }
  std::uint64_t torn_bytes() const { return taken_ - behind_last_; }
  std::uint64_t damaged_records() const { return damaged_records_; }

 private:
  Status TakeHeader(std::span<const std::byte> bytes) {
    INTAGLIO_TRY(CheckRecordHeader(kJournal, bytes));
    header_.point_count = NumberAt<std::uint64_t>(bytes.data() + 16);
    header_.epoch = NumberAt<std::uint64_t>(bytes.data() + 24);
    header_.path_crc = NumberAt<std::uint32_t>(bytes.data() + 32);
    header_.station = NumberAt<std::uint32_t>(bytes.data() + 36);
    if (header_.point_count <= kMaxPoints) return {};
    return Fail(ErrorCode::kTooLarge, "the journal has too many points",
                fmt::format("{}", header_.point_count));
  }
  void TakeRecord(std::span<const std::byte> bytes) {
    const auto record = DecodeRecord(bytes, header_);
    if (record) {
      damaged_records_ += (taken_ - behind_last_) / kJournalRecordSize;
      behind_last_ = taken_ + kJournalRecordSize;
      take_(header_, *record);
    }
    taken_ += kJournalRecordSize;
  }

  const TakeJournalRecord& take_;
  JournalHeader header_;
  std::uint64_t taken_ = 0, behind_last_ = 0, damaged_records_ = 0;
};

Status ReadPieces(const std::filesystem::path& file, JournalReader& reader) {
  // Whole records behind the header, whose size is two of them.
  constexpr std::size_t kPieceBytes = 32768 * kJournalRecordSize;
  static_assert(kJournalHeaderSize % kJournalRecordSize == 0);
  return io::ReadInPieces(file, kMaxJournalFile, kPieceBytes,
                          [&](std::span<const std::byte> piece, std::uint64_t) {
                            return reader.Receive(piece);
                          });
}

/// What `read` gives a reader, as a journal whose file has `size` bytes.
template <typename Read>
Result<Journal> Collected(std::uint64_t size, Read&& read) {
  Journal journal;
  const TakeJournalRecord keep = [&](const JournalHeader&, const JournalRecord& record) {
    if (journal.records.empty()) journal.records.reserve(size / kJournalRecordSize);
    journal.records.push_back(record);
  };
  JournalReader reader(keep);
  INTAGLIO_TRY(read(reader));
  journal.header = reader.header();
  journal.torn_bytes = reader.torn_bytes();
  journal.damaged_records = reader.damaged_records();
  return journal;
}

}  // namespace

Result<Journal> ParseJournal(std::span<const std::byte> bytes) {
  return Collected(bytes.size(),
                   [&](JournalReader& reader) { return reader.Receive(bytes); });
}

std::uint32_t PathCrc(const PointList& path_mm) {
  std::uint32_t crc = 0;
  for (const Vec3& p : path_mm) {
    crc = io::Crc32(std::as_bytes(std::span(p.data(), 3)), crc);
  }
  return crc;
}

Result<Journal> ReadJournal(const std::filesystem::path& file) {
  std::error_code no_size;  // Reading it gives the error.
  const std::uintmax_t size = std::filesystem::file_size(file, no_size);
  return Collected(no_size ? 0 : size,
                   [&](JournalReader& reader) { return ReadPieces(file, reader); });
}

Result<JournalHeader> ReadJournalRecords(const std::filesystem::path& file,
                                         const TakeJournalRecord& take) {
  JournalReader reader(take);
  INTAGLIO_TRY(ReadPieces(file, reader));
  return reader.header();
}

std::uint32_t PowerUpOfText(std::string_view text) {
  if (text.empty()) return 0;
  return std::max(1u, io::Crc32(std::as_bytes(std::span(text))));
}

std::vector<PointHistory> HistoryOf(const Journal& journal) {
  PointHistories histories;
  for (const JournalRecord& record : journal.records)
    histories.Receive(journal.header, record);
  return histories.Finish(journal.header);
}

void PointHistories::Receive(const JournalHeader& header, const JournalRecord& record) {
  if (record.kind == JournalKind::kSession) power_up_ = record.point;
  if (!IsOfPoint(record.kind)) return;
  if (of_points_.empty()) of_points_.resize(header.point_count);
  PointHistory& point = of_points_[record.point];
  if (record.kind == JournalKind::kReopened) {
    // It does not apply to any other state: an outcome may be missing in the file.
    if (point.outcome != PointOutcome::kUncertain || point.open_intent) return;
    point.outcome = PointOutcome::kNone;
    point.reopened = true;
    return;
  }
  point.tick = record.tick;
  point.power_up = power_up_;
  if (record.kind == JournalKind::kIntent) {
    point.open_intent = true;
    return;
  }
  point.open_intent = false;
  point.outcome = record.outcome;
  point.reason = record.reason;
  point.missed_channels = record.missed_channels;
  point.measured_mj = record.measured_mj;
  if (IsFired(record.outcome)) ++point.fired_count;
}

std::vector<PointHistory> PointHistories::Finish(const JournalHeader& header) {
  of_points_.resize(header.point_count);
  return std::move(of_points_);
}

}  // namespace intaglio::formats
