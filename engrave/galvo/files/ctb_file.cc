#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "engrave/galvo/files/correction_files.h"
#include "engrave/galvo/files/little_endian.h"

namespace intaglio::galvo {
namespace {

constexpr int kCtbNodes = 65, kCtbNodeBits = 1024, kCtbZero = 32768, kCtbLast = 65535;
constexpr std::size_t kCtbTableBytes = std::size_t{kCtbNodes} * kCtbNodes * 2;

}  // namespace

Result<FieldGrid> ReadCtb(std::string_view bytes, std::string_view name,
                          double bit_per_mm) {
  if (!(bit_per_mm > 0 && bit_per_mm <= 65536)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{}: a calibration of {} bit/mm; give one above 0 and up to "
                            "65536",
                            name, bit_per_mm),
                fmt::format("{}", bit_per_mm));
  }
  if (bytes.size() != 2 * kCtbTableBytes) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: has {} bytes, a .ctb file has {}; give the file as the "
                            "control board's maker supplies it",
                            name, bytes.size(), 2 * kCtbTableBytes),
                fmt::format("{}", bytes.size()));
  }
  FieldGrid grid{kCtbNodes, -kCtbZero / bit_per_mm, kCtbNodeBits / bit_per_mm, {}};
  const auto target = [](int i) { return std::min(i * kCtbNodeBits, kCtbLast); };
  for (int y = 0; y < kCtbNodes; ++y) {
    for (int x = 0; x < kCtbNodes; ++x) {
      const std::size_t at = 2 * static_cast<std::size_t>(y * kCtbNodes + x);
      const int out_x = LittleEndian<std::uint16_t>(bytes, at);
      const int out_y = LittleEndian<std::uint16_t>(bytes, kCtbTableBytes + at);
      grid.values_mm.emplace_back((out_x - target(x)) / bit_per_mm,
                                  (out_y - target(y)) / bit_per_mm);
    }
  }
  return grid;
}

}  // namespace intaglio::galvo
