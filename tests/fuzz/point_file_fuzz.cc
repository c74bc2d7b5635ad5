#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"

// The bytes are read as each format of points: a table that can be written again, or an
// error with a sentence.
namespace {

void CheckTable(const intaglio::Result<intaglio::formats::PointTable>& table) {
  using intaglio::Require;
  if (!table) {
    Require(!table.error().message.empty(), "an error without a sentence");
    return;
  }
  intaglio::formats::RequireWritable(*table);
}

/// The bytes as an SCL with right check sums, which chance would never find.
std::string Sealed(std::string_view text) {
  std::string bytes(text);
  std::uint32_t header_size = 0;
  if (bytes.size() < 16) return bytes;
  std::memcpy(&header_size, bytes.data() + 12, 4);
  if (header_size < 20 || bytes.size() < std::size_t{header_size} + 4) return bytes;
  const auto seal = [&](std::size_t begin, std::size_t end) {
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(bytes.data() + begin),
              static_cast<uInt>(end - begin)));
    std::memcpy(bytes.data() + end, &crc, 4);
  };
  seal(0, header_size - 4);
  seal(header_size, bytes.size() - 4);
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  CheckTable(intaglio::formats::ParsePly(text));
  CheckTable(intaglio::formats::ParseXyz(text));
  CheckTable(intaglio::formats::ParseCft(text));
  CheckTable(intaglio::formats::ParseScl(text));
  CheckTable(intaglio::formats::ParseScl(Sealed(text)));
  CheckTable(intaglio::formats::ParseDxf(text));
  return 0;
}
