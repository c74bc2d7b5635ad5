// Any bytes as a file of marks, and the same bytes behind a header whose checksum holds,
// for a right one would be rare: refused with a message, or marks that can be used and
// written again as they were.

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/io/crc32.h"
#include "engrave/mark/mark_file.h"

namespace {

using namespace intaglio;

constexpr std::size_t kMagic = 8, kHeader = 12;

void Try(std::span<const std::byte> bytes) {
  const auto set = mark::DecodeMarks(bytes);
  if (!set) {
    Require(!set.error().message.empty(), "an error without a sentence");
    return;
  }
  Require(mark::CheckMarks(*set).has_value(), "marks that are not checked");
  for (const mark::Mark& mark : set->marks)
    Require(mark::LengthOf(mark) >= 0, "a negative length");
  const auto written = mark::EncodeMarks(*set);
  Require(std::equal(written.begin(), written.end(), bytes.begin(), bytes.end()),
          "written again it is another file");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  Try(bytes);
  std::vector<std::byte> whole(kHeader);
  whole.insert(whole.end(), bytes.begin(), bytes.end());
  std::memcpy(whole.data(), "INTMRKS1", kMagic);
  const std::uint32_t crc = io::Crc32(bytes);
  std::memcpy(whole.data() + kMagic, &crc, sizeof(crc));
  Try(whole);
  return 0;
}
