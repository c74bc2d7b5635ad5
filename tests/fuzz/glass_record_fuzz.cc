// Any bytes as the record of a glass: its cracks, or an error with a message. The same
// bytes as the fields of a record, whose checksums hold: what is read and written again
// is the same.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "engrave/formats/glass_record.h"

namespace {

using namespace intaglio::formats;

std::vector<std::byte> Written(const GlassHeader& header,
                               std::span<const GlassCrack> cracks) {
  std::vector<std::byte> bytes = EncodeGlassHeader(header);
  for (const GlassCrack& crack : cracks) AppendGlassCrack(crack, bytes);
  return bytes;
}

void Try(std::span<const std::byte> bytes) {
  const auto record = ParseGlassRecord(bytes);
  if (!record) {
    if (record.error().message.empty()) std::abort();
    return;
  }
  if (kGlassHeaderSize + record->cracks.size() * kGlassRecordSize + record->torn_bytes !=
      bytes.size()) {
    std::abort();
  }
  const auto written = Written(record->header, record->cracks);
  const auto again = ParseGlassRecord(written);
  if (!again || again->torn_bytes != 0) std::abort();
  if (Written(again->header, again->cracks) != written) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  Try(std::as_bytes(std::span(bytes, size)));
  if (size < 24) return 0;
  GlassHeader header;
  std::memcpy(header.block_size_mm.data(), bytes, 24);
  std::vector<GlassCrack> cracks;
  constexpr std::size_t kFields = 42;
  for (std::size_t at = 24; at + kFields <= size; at += kFields) {
    GlassCrack crack;
    std::memcpy(&crack.tick, bytes + at, 8);
    std::memcpy(crack.position_mm.data(), bytes + at + 8, 24);
    std::memcpy(&crack.pulse_energy_mj, bytes + at + 32, 8);
    crack.channel = bytes[at + 40] % 4;
    crack.station = static_cast<std::uint8_t>(1 + bytes[at + 40] / 4);
    crack.in_glass = (bytes[at + 41] & 1) != 0;
    crack.length_mm = bytes[at + 41] / 10.0;
    cracks.push_back(crack);
  }
  std::vector<std::byte> whole = Written(header, cracks);
  Try(whole);
  // A damaged byte ends the record there and takes nothing else with it.
  const std::size_t damaged = bytes[0] * size % whole.size();
  whole[damaged] ^= std::byte(1);
  Try(whole);
  return 0;
}
