#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/formats/ply_vertices.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/ply_header.h"
#include "engrave/io/ply_values.h"
#include "engrave/io/whole_file.h"

namespace intaglio::formats {
namespace {

using io::PlyElement;
using io::PlyEncoding;
using io::PlyHeader;
using io::PlyProperty;
using io::PlyType;
using io::PlyValues;

tl::unexpected<Error> CutOff(const PlyElement& element, std::uint64_t row) {
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("the file ends, or is damaged, in row {} of the {} of element {}; "
                  "write it again",
                  row + 1, element.count, element.name));
}

tl::unexpected<Error> GoesOn() {
  return Fail(
      ErrorCode::kUnreadable,
      "the file goes on behind its last vertex: its header declares fewer rows "
      "than it has, or its rows have more values than properties; write it again");
}

/// Reads one row; gives each scalar value to `keep` with the property's index.
template <typename Keep>
bool ReadRow(const PlyElement& element, PlyValues& values, Keep keep) {
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const PlyProperty& property = element.properties[p];
    double passed_over_count = 0;
    if (property.is_list) {
      const std::optional<double> count = values.Next(property.count_type);
      if (!count || *count < 0) return false;
      passed_over_count = *count;
    }
    for (double i = 0; i < passed_over_count; ++i) {
      if (!values.Next(property.type)) return false;
    }
    if (property.is_list) continue;
    const std::optional<double> value = values.Next(property.type);
    if (!value) return false;
    keep(p, *value);
  }
  return true;
}

Status PassOver(const PlyElement& element, PlyValues& values) {
  if (element.properties.empty()) return {};
  for (std::uint64_t row = 0; row < element.count; ++row) {
    if (!ReadRow(element, values, [](std::size_t, double) {}))
      return CutOff(element, row);
  }
  return {};
}

/// Of the type in which a property's values are kept, with room for them.
NamedColumn ColumnOf(const PlyProperty& property, std::uint64_t count) {
  const auto with_room = [&](auto values) -> NamedColumn {
    values.reserve(count);
    return {property.name, std::move(values)};
  };
  switch (property.type) {
    case PlyType::kUint8:
      return with_room(std::vector<std::uint8_t>());
    case PlyType::kUint32:
      return with_room(std::vector<std::uint32_t>());
    case PlyType::kFloat:
      return with_room(std::vector<float>());
    case PlyType::kDouble:
      return with_room(std::vector<double>());
    default:
      return with_room(std::vector<std::int32_t>());
  }
}

void Append(double value, NamedColumn& column) {
  std::visit(
      [&](auto& values) {
        using Value = typename std::decay_t<decltype(values)>::value_type;
        values.push_back(static_cast<Value>(value));
      },
      column.values);
}

/// Index of the one scalar property of that name.
std::optional<std::size_t> ScalarNamed(const PlyElement& element, std::string_view name) {
  std::optional<std::size_t> found;
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    if (element.properties[p].name != name) continue;
    if (found || element.properties[p].is_list) return std::nullopt;
    found = p;
  }
  return found;
}

Result<std::array<std::size_t, 3>> CoordinatesOf(const PlyElement& vertices) {
  std::array<std::size_t, 3> coordinates{};
  constexpr std::array<std::string_view, 3> kNames = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto index = ScalarNamed(vertices, kNames[axis]);
    if (!index) {
      return Fail(
          ErrorCode::kMissing,
          fmt::format("its vertices do not have one property {}; a point file has "
                      "x, y and z",
                      kNames[axis]));
    }
    coordinates[axis] = *index;
  }
  return coordinates;
}

}  // namespace

Result<PlyVertices> PlyVertices::Begin(const PlyElement& vertices, std::size_t rest_size,
                                       const PointFileLimits& limits) {
  if (vertices.count > limits.max_points) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("it has {} points, more than the {} allowed; thin it out or "
                            "raise the limit",
                            vertices.count, limits.max_points));
  }
  PlyVertices reader(vertices);
  reader.coordinates_ = INTAGLIO_TRY(CoordinatesOf(vertices));
  // A row has at least three values of at least a byte, so no more rows are allocated
  // than the file can hold.
  if (vertices.count > rest_size / 3) return CutOff(vertices, rest_size / 3);
  reader.points_mm_.reserve(vertices.count);
  for (std::size_t p = 0; p < vertices.properties.size(); ++p) {
    const PlyProperty& property = vertices.properties[p];
    const bool is_column =
        !property.is_list && std::ranges::count(reader.coordinates_, p) == 0;
    reader.columns_.push_back(is_column ? ColumnOf(property, vertices.count)
                                        : NamedColumn());
  }
  return reader;
}

Status PlyVertices::Read(std::uint64_t row_count, PlyValues& values) {
  std::vector<double> row(vertices_.properties.size());
  for (; row_count > 0 && !complete(); --row_count) {
    if (!ReadRow(vertices_, values, [&](std::size_t p, double value) { row[p] = value; }))
      return CutOff(vertices_, read_count_);
    ++read_count_;
    points_mm_.emplace_back(row[coordinates_[0]], row[coordinates_[1]],
                            row[coordinates_[2]]);
    for (std::size_t p = 0; p < row.size(); ++p) {
      if (!columns_[p].name.empty()) Append(row[p], columns_[p]);
    }
  }
  return {};
}

Result<PointTable> PlyVertices::Finish() {
  if (!complete()) return CutOff(vertices_, read_count_);
  for (std::size_t row = 0; row < points_mm_.size(); ++row) {
    const Vec3& p = points_mm_[row];
    if (p.allFinite()) continue;
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format(
            "point {} is at ({}, {}, {}), which is not finite; remove it from the file",
            row + 1, p.x(), p.y(), p.z()));
  }
  std::erase_if(columns_, [](const NamedColumn& column) { return column.name.empty(); });
  return PointTable{std::move(points_mm_), std::move(columns_), {}};
}

Result<PointTable> ReadVertices(const PlyElement& vertices, std::size_t rest_size,
                                PlyValues& values, const PointFileLimits& limits) {
  PlyVertices reader = INTAGLIO_TRY(PlyVertices::Begin(vertices, rest_size, limits));
  INTAGLIO_TRY(reader.Read(vertices.count, values));
  return reader.Finish();
}

std::uint64_t RowSize(PlyEncoding encoding, const PlyElement& element) {
  if (encoding == PlyEncoding::kAscii) return 0;
  std::uint64_t size = 0;
  for (const PlyProperty& property : element.properties) {
    if (property.is_list) return 0;
    size += io::SizeOf(property.type);
  }
  return size;
}

namespace {

void AddComments(const PlyHeader& header, PointTable& table) {
  for (const std::string& comment : header.comments)
    table.comments.push_back(OneLine(comment));
}

/// A binary file whose first element is "vertex", without lists.
bool HasRows(const PlyHeader& header) {
  return !header.elements.empty() && header.elements.front().name == "vertex" &&
         RowSize(header.encoding, header.elements.front()) > 0;
}

/// A file that HasRows() from its bytes in pieces, the first with the header.
class PlyPieces {
 public:
  PlyPieces(const PlyHeader& header, const PointFileLimits& limits)
      : header_(header),
        limits_(limits),
        row_size_(RowSize(header.encoding, header.elements.front())) {}

  /// `size`: of all pieces.
  Status Receive(std::span<const std::byte> piece, std::uint64_t size) {
    begun_.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    if (!vertices_) {
      const PlyElement& element = header_.elements.front();
      const std::uint64_t rest_size = size - header_.size;
      const bool is_alone = header_.elements.size() == 1;
      if (is_alone && rest_size / row_size_ > element.count) return GoesOn();
      begun_.erase(0, header_.size);
      auto vertices = INTAGLIO_TRY(PlyVertices::Begin(element, rest_size, limits_));
      vertices_ = std::move(vertices);
    }
    const std::uint64_t rows = begun_.size() / row_size_;
    const auto values = io::PlyValuesOf(header_.encoding, begun_);
    INTAGLIO_TRY(vertices_->Read(rows, *values));
    begun_.erase(0, rows * row_size_);
    return {};
  }
  Result<PointTable> Finish() {
    PointTable table = INTAGLIO_TRY(vertices_->Finish());
    AddComments(header_, table);
    return table;
  }

 private:
  const PlyHeader& header_;
  PointFileLimits limits_;
  std::uint64_t row_size_;
  std::optional<PlyVertices> vertices_;
  std::string begun_;  // bytes that are not rows yet
};

}  // namespace

Result<PointTable> ParsePly(std::string_view bytes, const PointFileLimits& limits) {
  const PlyHeader header = INTAGLIO_TRY(io::ParsePlyHeader(bytes));
  const std::string_view rest = bytes.substr(header.size);
  const std::unique_ptr<PlyValues> values = io::PlyValuesOf(header.encoding, rest);
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      Result<PointTable> table = ReadVertices(element, rest.size(), *values, limits);
      if (&element == &header.elements.back() && table && values->has_more())
        return GoesOn();
      if (table) AddComments(header, *table);
      return table;
    }
    INTAGLIO_TRY(PassOver(element, *values));
  }
  return Fail(ErrorCode::kMissing,
              "it has no element \"vertex\"; a point file has vertices with x, y and z");
}

Result<PointTable> ReadPly(const std::filesystem::path& file,
                           const PointFileLimits& limits) {
  constexpr std::uint64_t kPieceBytes = 1 << 20;
  const std::string beginning = INTAGLIO_TRY(io::ReadBeginning(file, kPieceBytes));
  const auto header = io::ParsePlyHeader(beginning);
  if (!header || !HasRows(*header)) return ReadAndParse(file, limits, ParsePly);
  PlyPieces pieces(*header, limits);
  INTAGLIO_TRY(
      io::ReadInPieces(file, limits.max_file_bytes, kPieceBytes,
                       [&](std::span<const std::byte> piece, std::uint64_t size) {
                         return pieces.Receive(piece, size);
                       }));
  return pieces.Finish().map_error(
      [&](Error error) { return io::AboutFile(std::move(error), file); });
}

}  // namespace intaglio::formats
