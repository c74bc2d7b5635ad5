// Any bytes as the record of a tool's way: its steps, or an error with a message. The
// same bytes as the fields of records whose checksums hold: what is read and written
// again is the same.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "engrave/formats/tool_way.h"

namespace {

using namespace intaglio::formats;

std::vector<std::byte> Written(const ToolWay& way) {
  std::vector<std::byte> bytes = EncodeToolWayHeader(way.header);
  for (const ToolWayStep& step : way.steps) AppendToolWayStep(step, bytes);
  return bytes;
}

void Try(std::span<const std::byte> bytes) {
  const auto way = ParseToolWay(bytes);
  if (!way) {
    if (way.error().message.empty()) std::abort();
    return;
  }
  if (kToolWayHeaderSize + way->steps.size() * kToolWayStepSize + way->torn_bytes !=
      bytes.size())
    std::abort();
  const auto written = Written(*way);
  const auto again = ParseToolWay(written);
  if (!again || again->torn_bytes != 0 || Written(*again) != written) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  Try(std::as_bytes(std::span(bytes, size)));
  if (size < 25) return 0;
  ToolWay way;
  std::memcpy(&way.header.tool_diameter_mm, bytes, 8);
  std::memcpy(&way.header.sheet_thickness_mm, bytes + 8, 8);
  std::memcpy(&way.header.sheet_height_mm, bytes + 16, 8);
  way.header.is_laser = bytes[24] % 2 == 1;
  constexpr std::size_t kFields = 41;
  for (std::size_t at = 25; at + kFields <= size; at += kFields) {
    ToolWayStep step;
    std::memcpy(&step.end_us, bytes + at, 8);
    std::memcpy(step.end_mm.data(), bytes + at + 8, 24);
    std::memcpy(&step.power, bytes + at + 32, 8);
    step.is_on = bytes[at + 40] % 2 == 1;
    way.steps.push_back(step);
  }
  std::vector<std::byte> whole = Written(way);
  Try(whole);
  whole[bytes[0] * size % whole.size()] ^= std::byte(1);
  Try(whole);
  return 0;
}
