#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/formats/point_file.h"

// The bytes are read as PLY and as XYZ: finite points and columns of their length, or an
// error with a sentence.
namespace {

void CheckTable(const intaglio::Result<intaglio::formats::PointTable>& table) {
  using intaglio::Require;
  if (!table) {
    Require(!table.error().message.empty(), "an error without a sentence");
    return;
  }
  for (const intaglio::Vec3& p : table->points_mm) {
    Require(p.allFinite(), "a point that is not finite");
  }
  for (const auto& column : table->columns) {
    const std::size_t count =
        std::visit([](const auto& values) { return values.size(); }, column.values);
    Require(count == table->points_mm.size(), "a column of another length");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  CheckTable(intaglio::formats::ParsePly(text));
  CheckTable(intaglio::formats::ParseXyz(text));
  return 0;
}
