#include "engrave/formats/mark_record.h"

#include <cmath>

#include "engrave/core/try.h"
#include "engrave/formats/record_file.h"
#include "engrave/io/atomic_file.h"

namespace intaglio::formats {
namespace {

constexpr RecordKind kMark{"INTMARK1", "mark record",   1,
                           2,          kMarkHeaderSize, kMarkRecordSize};
constexpr std::size_t kMaxMarkFile = std::size_t{1} << 30;

}  // namespace

std::vector<std::byte> EncodeMarkHeader(const MarkRecordHeader& header) {
  std::vector<std::byte> bytes = NewRecordHeader(kMark);
  PutNumber(bytes.data() + 16, header.field_mm);
  PutNumber(bytes.data() + 24, header.power_up);
  Seal(bytes);
  return bytes;
}

void AppendBurntTick(const BurntTick& tick, std::vector<std::byte>& out) {
  const std::span<std::byte> record = AppendRecord(kMark, out);
  std::byte* at = record.data();
  PutNumber(at, tick.tick);
  for (int axis = 0; axis < 2; ++axis) {
    PutNumber(at + 8 + 8 * axis, tick.place_mm[axis]);
    PutNumber(at + 24 + 4 * axis, static_cast<float>(tick.way_mm[axis]));
  }
  PutNumber(at + 32, static_cast<float>(tick.energy_mj));
  PutNumber(at + 36, tick.run);
  PutNumber(at + 40, tick.mark);
  Seal(record);
}

void AppendPrintMark(const PrintMark& mark, std::vector<std::byte>& out) {
  BurntTick record;
  record.tick = mark.tick;
  record.place_mm.x() = mark.place_mm;
  record.mark = kPrintMark;
  AppendBurntTick(record, out);
}

Result<MarkRecord> ParseMarkRecord(std::span<const std::byte> bytes) {
  INTAGLIO_TRY(CheckRecordHeader(kMark, bytes));
  MarkRecord record;
  record.header.field_mm = NumberAt<double>(bytes.data() + 16);
  record.header.power_up = NumberAt<std::uint32_t>(bytes.data() + 24);
  record.ticks.reserve(RecordRoom(kMark, bytes));
  record.torn_bytes = ReadRecords(kMark, bytes, [&](const std::byte* at) {
    BurntTick tick;
    tick.tick = NumberAt<std::uint64_t>(at);
    for (int axis = 0; axis < 2; ++axis) {
      tick.place_mm[axis] = NumberAt<double>(at + 8 + 8 * axis);
      tick.way_mm[axis] = NumberAt<float>(at + 24 + 4 * axis);
    }
    tick.energy_mj = NumberAt<float>(at + 32);
    if (!tick.place_mm.allFinite() || !tick.way_mm.allFinite() ||
        !std::isfinite(tick.energy_mj))
      return false;
    tick.run = NumberAt<std::uint32_t>(at + 36);
    tick.mark = NumberAt<std::uint32_t>(at + 40);
    if (tick.mark == kPrintMark) {
      record.prints.push_back({tick.tick, tick.place_mm.x()});
    } else {
      record.ticks.push_back(tick);
    }
    return true;
  });
  return record;
}

Result<MarkRecord> ReadMarkRecord(const std::filesystem::path& file) {
  return ReadRecordFile(file, kMaxMarkFile, ParseMarkRecord);
}

Result<MarkRecordHeader> ReadMarkHeader(const std::filesystem::path& file) {
  return ReadRecordHeader(kMark, file, ParseMarkRecord).map([](const MarkRecord& record) {
    return record.header;
  });
}

Status WriteMarkRecord(const std::filesystem::path& file, const MarkRecord& record) {
  auto bytes = EncodeMarkHeader(record.header);
  bytes.reserve(bytes.size() + record.ticks.size() * kMarkRecordSize);
  for (const BurntTick& tick : record.ticks) AppendBurntTick(tick, bytes);
  for (const PrintMark& mark : record.prints) AppendPrintMark(mark, bytes);
  return io::WriteFileAtomically(file, std::span<const std::byte>(bytes));
}

}  // namespace intaglio::formats
