#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "engrave/core/try.h"
#include "engrave/formats/ply_vertices.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/ply_header.h"
#include "engrave/io/ply_values.h"

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

template <typename T>
NamedColumn::Values Converted(const std::vector<double>& values) {
  return std::vector<T>(values.begin(), values.end());
}

NamedColumn ColumnOf(const PlyProperty& property, std::vector<double>& values) {
  switch (property.type) {
    case PlyType::kUint8:
      return {property.name, Converted<std::uint8_t>(values)};
    case PlyType::kUint32:
      return {property.name, Converted<std::uint32_t>(values)};
    case PlyType::kFloat:
      return {property.name, Converted<float>(values)};
    case PlyType::kDouble:
      return {property.name, std::move(values)};
    default:
      return {property.name, Converted<std::int32_t>(values)};
  }
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

Result<PointTable> ReadVertices(const PlyElement& vertices, std::size_t rest_size,
                                PlyValues& values, const PointFileLimits& limits) {
  if (vertices.count > limits.max_points) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("it has {} points, more than the {} allowed; thin it out or "
                            "raise the limit",
                            vertices.count, limits.max_points));
  }
  const auto coordinates = INTAGLIO_TRY(CoordinatesOf(vertices));
  // A row has at least three values of at least a byte, so no more rows are allocated
  // than the file can hold.
  if (vertices.count > rest_size / 3) return CutOff(vertices, rest_size / 3);
  std::vector<std::vector<double>> columns(vertices.properties.size());
  for (std::size_t p = 0; p < columns.size(); ++p) {
    if (!vertices.properties[p].is_list) columns[p].reserve(vertices.count);
  }
  for (std::uint64_t row = 0; row < vertices.count; ++row) {
    const bool complete = ReadRow(vertices, values, [&](std::size_t p, double value) {
      columns[p].push_back(value);
    });
    if (!complete) return CutOff(vertices, row);
  }
  PointTable table;
  table.points_mm.reserve(vertices.count);
  for (std::uint64_t row = 0; row < vertices.count; ++row) {
    const Vec3 p(columns[coordinates[0]][row], columns[coordinates[1]][row],
                 columns[coordinates[2]][row]);
    if (!p.allFinite()) {
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format(
              "point {} is at ({}, {}, {}), which is not finite; remove it from the file",
              row + 1, p.x(), p.y(), p.z()));
    }
    table.points_mm.push_back(p);
  }
  for (std::size_t p = 0; p < columns.size(); ++p) {
    const bool is_coordinate =
        std::find(coordinates.begin(), coordinates.end(), p) != coordinates.end();
    if (is_coordinate || vertices.properties[p].is_list) continue;
    table.columns.push_back(ColumnOf(vertices.properties[p], columns[p]));
  }
  return table;
}

Result<PointTable> ParsePly(std::string_view bytes, const PointFileLimits& limits) {
  const PlyHeader header = INTAGLIO_TRY(io::ParsePlyHeader(bytes));
  const std::string_view rest = bytes.substr(header.size);
  const std::unique_ptr<PlyValues> values = io::PlyValuesOf(header.encoding, rest);
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      Result<PointTable> table = ReadVertices(element, rest.size(), *values, limits);
      if (!table) return table;
      for (const std::string& comment : header.comments) {
        table->comments.push_back(OneLine(comment));
      }
      return table;
    }
    INTAGLIO_TRY(PassOver(element, *values));
  }
  return Fail(ErrorCode::kMissing,
              "it has no element \"vertex\"; a point file has vertices with x, y and z");
}

Result<PointTable> ReadPly(const std::filesystem::path& file,
                           const PointFileLimits& limits) {
  return ReadAndParse(file, limits, ParsePly);
}

}  // namespace intaglio::formats
