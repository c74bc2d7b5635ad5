#include "engrave/formats/journal_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>

#include "engrave/io/crc32.h"

namespace intaglio::formats {
namespace {

constexpr char kJournalMagic[] = "INTJRNL1";
constexpr std::uint32_t kJournalVersion = 2;
// A record's point must not make the reader allocate without bound.
constexpr std::uint64_t kMaxPoints = 100'000'000;

template <typename T>
void Put(std::span<std::byte> bytes, std::size_t offset, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[offset + i] =
        static_cast<std::byte>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xffu);
  }
}

template <typename T>
T Get(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= static_cast<std::uint64_t>(bytes[offset + i]) << (8 * i);
  }
  return static_cast<T>(value);
}

bool CrcHolds(std::span<const std::byte> bytes) {
  const std::size_t end = bytes.size() - 4;
  return io::Crc32(bytes.first(end)) == Get<std::uint32_t>(bytes, end);
}

std::optional<JournalRecord> DecodeRecord(std::span<const std::byte> bytes,
                                          const JournalHeader& header) {
  const auto kind = static_cast<JournalKind>(bytes[0]);
  const bool of_point = IsOfPoint(kind);
  const bool known =
      of_point || kind == JournalKind::kSession || kind == JournalKind::kConsent;
  const auto point = Get<std::uint32_t>(bytes, 16);
  if (!CrcHolds(bytes) || !known || (of_point && point >= header.point_count) ||
      bytes[1] > static_cast<std::byte>(PointOutcome::kLeftOut)) {
    return std::nullopt;
  }
  JournalRecord record{kind,
                       static_cast<PointOutcome>(bytes[1]),
                       static_cast<std::uint8_t>(bytes[2]),
                       Get<std::uint32_t>(bytes, 4),
                       Get<std::uint64_t>(bytes, 8),
                       point,
                       Get<std::uint32_t>(bytes, 24)};
  const auto extra = Get<std::uint32_t>(bytes, 20);
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
  std::memcpy(bytes.data(), kJournalMagic, 8);
  Put<std::uint32_t>(bytes, 8, kJournalVersion);
  Put<std::uint32_t>(bytes, 12, kJournalRecordSize);
  Put<std::uint64_t>(bytes, 16, header.point_count);
  Put<std::uint64_t>(bytes, 24, header.epoch);
  Put<std::uint32_t>(bytes, 32, header.path_crc);
  Put<std::uint32_t>(bytes, 36, header.station);
  Put<std::uint32_t>(bytes, 60, io::Crc32(std::span(bytes).first(60)));
  return bytes;
}

std::array<std::byte, kJournalRecordSize> EncodeJournalRecord(
    const JournalRecord& record) {
  std::array<std::byte, kJournalRecordSize> bytes{};
  bytes[0] = static_cast<std::byte>(record.kind);
  bytes[1] = static_cast<std::byte>(record.outcome);
  bytes[2] = static_cast<std::byte>(record.reason);
  Put<std::uint32_t>(bytes, 4, record.run);
  Put<std::uint64_t>(bytes, 8, record.tick);
  Put<std::uint32_t>(bytes, 16, record.point);
  const bool has_outcome = record.kind == JournalKind::kOutcome;
  if (has_outcome) bytes[3] = static_cast<std::byte>(record.missed_channels);
  Put<std::uint32_t>(
      bytes, 20,
      has_outcome ? std::bit_cast<std::uint32_t>(record.measured_mj) : record.openings);
  Put<std::uint32_t>(bytes, 24, record.pulse_count);
  Put<std::uint32_t>(bytes, 28, io::Crc32(std::span(bytes).first(28)));
  return bytes;
}

Result<Journal> ParseJournal(std::span<const std::byte> bytes) {
  if (bytes.size() < kJournalHeaderSize ||
      std::memcmp(bytes.data(), kJournalMagic, 8) != 0 ||
      !CrcHolds(bytes.first(kJournalHeaderSize))) {
    return Fail(ErrorCode::kUnreadable,
                "not an engraving journal: its header is missing or damaged");
  }
  if (const auto version = Get<std::uint32_t>(bytes, 8); version != kJournalVersion) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the journal has version {}; this program reads version {}",
                            version, kJournalVersion),
                fmt::format("{}", version));
  }
  Journal journal;
  journal.header.point_count = Get<std::uint64_t>(bytes, 16);
  journal.header.epoch = Get<std::uint64_t>(bytes, 24);
  journal.header.path_crc = Get<std::uint32_t>(bytes, 32);
  journal.header.station = Get<std::uint32_t>(bytes, 36);
  if (journal.header.point_count > kMaxPoints) {
    return Fail(ErrorCode::kTooLarge, "the journal has too many points",
                fmt::format("{}", journal.header.point_count));
  }
  std::size_t behind_last = kJournalHeaderSize;
  for (std::size_t offset = kJournalHeaderSize;
       offset + kJournalRecordSize <= bytes.size(); offset += kJournalRecordSize) {
    const auto record =
        DecodeRecord(bytes.subspan(offset, kJournalRecordSize), journal.header);
    if (!record) continue;
    journal.damaged_records += (offset - behind_last) / kJournalRecordSize;
    behind_last = offset + kJournalRecordSize;
    journal.records.push_back(*record);
  }
  journal.torn_bytes = bytes.size() - behind_last;
  return journal;
}

std::uint32_t PathCrc(const PointList& path_mm) {
  std::uint32_t crc = 0;
  for (const Vec3& p : path_mm) {
    crc = io::Crc32(std::as_bytes(std::span(p.data(), 3)), crc);
  }
  return crc;
}

Result<Journal> ReadJournal(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("cannot open the journal {}", file.string()), file.string());
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(in.tellg()));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()),
          static_cast<std::streamsize>(bytes.size()));
  if (!in) {
    return Fail(ErrorCode::kIo, fmt::format("cannot read the journal {}", file.string()),
                file.string());
  }
  return ParseJournal(bytes).map_error([&](Error error) {
    error.message = file.string() + ": " + error.message;
    return error;
  });
}

std::uint32_t PowerUpOfText(std::string_view text) {
  if (text.empty()) return 0;
  return std::max(1u, io::Crc32(std::as_bytes(std::span(text))));
}

std::vector<PointHistory> HistoryOf(const Journal& journal) {
  std::vector<PointHistory> history(journal.header.point_count);
  std::uint32_t power_up = 0;
  for (const JournalRecord& record : journal.records) {
    if (record.kind == JournalKind::kSession) power_up = record.point;
    if (!IsOfPoint(record.kind)) continue;
    PointHistory& point = history[record.point];
    if (record.kind == JournalKind::kReopened) {
      // It does not apply to any other state: an outcome may be missing in the file.
      if (point.outcome != PointOutcome::kUncertain || point.open_intent) continue;
      point.outcome = PointOutcome::kNone;
      point.reopened = true;
      continue;
    }
    point.tick = record.tick;
    point.power_up = power_up;
    if (record.kind == JournalKind::kIntent) {
      point.open_intent = true;
      continue;
    }
    point.open_intent = false;
    point.outcome = record.outcome;
    point.reason = record.reason;
    point.missed_channels = record.missed_channels;
    point.measured_mj = record.measured_mj;
    if (IsFired(record.outcome)) ++point.fired_count;
  }
  return history;
}

}  // namespace intaglio::formats
