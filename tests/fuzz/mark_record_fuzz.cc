// Any bytes as the record of a virtual scan head: its ticks, or an error with a message.
// The same bytes as the fields of records whose checksums hold: what is read and written
// again is the same.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "engrave/formats/mark_record.h"

namespace {

using namespace intaglio::formats;

std::vector<std::byte> Written(const MarkRecord& record) {
  std::vector<std::byte> bytes = EncodeMarkHeader(record.header);
  for (const BurntTick& tick : record.ticks) AppendBurntTick(tick, bytes);
  for (const PrintMark& mark : record.prints) AppendPrintMark(mark, bytes);
  return bytes;
}

void Try(std::span<const std::byte> bytes) {
  const auto record = ParseMarkRecord(bytes);
  if (!record) {
    if (record.error().message.empty()) std::abort();
    return;
  }
  const std::size_t records = record->ticks.size() + record->prints.size();
  if (kMarkHeaderSize + records * kMarkRecordSize + record->torn_bytes != bytes.size())
    std::abort();
  const auto written = Written(*record);
  const auto again = ParseMarkRecord(written);
  if (!again || again->torn_bytes != 0 || Written(*again) != written) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  Try(std::as_bytes(std::span(bytes, size)));
  if (size < 8) return 0;
  MarkRecord record;
  std::memcpy(&record.header.field_mm, bytes, 8);
  constexpr std::size_t kFields = 44;
  for (std::size_t at = 8; at + kFields <= size; at += kFields) {
    BurntTick tick;
    float way[2], energy;
    std::memcpy(&tick.tick, bytes + at, 8);
    std::memcpy(tick.place_mm.data(), bytes + at + 8, 16);
    std::memcpy(way, bytes + at + 24, 8);
    std::memcpy(&energy, bytes + at + 32, 4);
    tick.way_mm = {way[0], way[1]};
    tick.energy_mj = energy;
    std::memcpy(&tick.run, bytes + at + 36, 4);
    std::memcpy(&tick.mark, bytes + at + 40, 4);
    record.ticks.push_back(tick);
  }
  std::vector<std::byte> whole = Written(record);
  Try(whole);
  whole[bytes[0] * size % whole.size()] ^= std::byte(1);
  Try(whole);
  return 0;
}
