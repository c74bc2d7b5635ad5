#include <fmt/format.h>

#include <array>
#include <bit>

#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/atomic_file.h"

namespace intaglio::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

// In the order of the alternatives of NamedColumn::Values.
constexpr std::array<const char*, 5> kTypeNames = {"double", "float", "int", "uint",
                                                   "uchar"};
static_assert(std::variant_size_v<NamedColumn::Values> == kTypeNames.size());

std::string HeaderOf(const PointTable& table) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : table.comments) {
    header += fmt::format("comment {}\n", comment);
  }
  header += fmt::format(
      "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
      table.points_mm.size());
  for (const NamedColumn& column : table.columns) {
    header +=
        fmt::format("property {} {}\n", kTypeNames[column.values.index()], column.name);
  }
  return header + "end_header\n";
}

template <typename T>
void AppendValue(T value, std::vector<std::byte>& row) {
  const auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
  row.insert(row.end(), bytes.begin(), bytes.end());
}

}  // namespace

Status WritePly(const std::filesystem::path& file, const PointTable& table) {
  RequireWritable(table);
  io::AtomicFile out = INTAGLIO_TRY(io::AtomicFile::Create(file));
  INTAGLIO_TRY(out.Write(HeaderOf(table)));
  std::vector<std::byte> row;
  for (std::size_t i = 0; i < table.points_mm.size(); ++i) {
    row.clear();
    for (int axis = 0; axis < 3; ++axis) AppendValue(table.points_mm[i][axis], row);
    for (const NamedColumn& column : table.columns) {
      std::visit([&](const auto& values) { AppendValue(values[i], row); }, column.values);
    }
    if (Status status = out.Write(row); !status) return status;
  }
  return out.Commit();
}

}  // namespace intaglio::formats
