#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "engrave/core/try.h"
#include "engrave/galvo/files/correction_files.h"
#include "engrave/galvo/files/little_endian.h"

namespace intaglio::galvo {
namespace {

constexpr int kCorNodes = 65, kField = 65536, kNodeUnits = kField / (kCorNodes - 1);
constexpr std::size_t kCorCells = std::size_t{kCorNodes} * kCorNodes;
constexpr double kMinScale = 1, kMaxScale = 1e9;  // unit/mm: fields of 66 m to 0.07 um

struct Layout {
  std::size_t scale_at, nodes_at, number_bytes, file_bytes;
};
constexpr Layout kVersion2 = {28, 36, 4, 36 + kCorCells * 8 + 4};
constexpr Layout kVersion1 = {24 + 43 * 8, 528, 8, 528 + kCorCells * 16};

/// Compares a name in bytes or in UTF-16, as both occur.
bool BeginsWith(std::string_view bytes, std::string_view title) {
  if (bytes.starts_with(title)) return true;
  if (bytes.size() < 2 * title.size()) return false;
  for (std::size_t i = 0; i < title.size(); ++i)
    if (bytes[2 * i] != title[i] || bytes[2 * i + 1] != 0) return false;
  return true;
}

Result<Layout> LayoutOf(std::string_view bytes, std::string_view name) {
  const bool second = BeginsWith(bytes, "JCZ_COR_2_1");
  if (!second && !BeginsWith(bytes, "LMC1COR_1.0")) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: begins with neither JCZ_COR_2_1 nor LMC1COR_1.0; give a "
                            ".cor file of an LMC board",
                            name));
  }
  const Layout layout = second ? kVersion2 : kVersion1;
  const bool fits =
      second ? bytes.size() == layout.file_bytes : bytes.size() >= layout.file_bytes;
  if (!fits) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: has {} bytes, a file of its version has {}; copy it "
                            "again",
                            name, bytes.size(), layout.file_bytes),
                fmt::format("{}", bytes.size()));
  }
  return layout;
}

}  // namespace

Result<FieldGrid> ReadCor(std::string_view bytes, std::string_view name) {
  const Layout layout = INTAGLIO_TRY(LayoutOf(bytes, name));
  const double scale = LittleEndian<double>(bytes, layout.scale_at);
  if (!(scale >= kMinScale && scale <= kMaxScale)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{}: a scale of {} unit/mm is outside {}..{:g}; copy the "
                            "file again",
                            name, scale, kMinScale, kMaxScale),
                fmt::format("{}", scale));
  }
  FieldGrid grid{kCorNodes, -kField / 2 / scale, kNodeUnits / scale, {}};
  for (std::size_t cell = 0; cell < kCorCells; ++cell) {
    const auto number = [&](std::size_t i) {
      const std::size_t at = layout.nodes_at + (2 * cell + i) * layout.number_bytes;
      return layout.number_bytes == 4 ? LittleEndian<std::int32_t>(bytes, at)
                                      : LittleEndian<double>(bytes, at);
    };
    const Vec2 by(number(0), number(1));
    if (!(std::abs(by.x()) <= kField && std::abs(by.y()) <= kField)) {
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("{}: row {}, column {}: a correction of ({}, {}) units is "
                      "more than the field of {}; copy the file again",
                      name, cell / kCorNodes, cell % kCorNodes, by.x(), by.y(), kField),
          fmt::format("{}", by.x()));
    }
    grid.values_mm.push_back(by / scale);
  }
  return grid;
}

}  // namespace intaglio::galvo
