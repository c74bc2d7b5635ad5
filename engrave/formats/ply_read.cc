#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>

#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/number_text.h"
#include "engrave/io/ply_header.h"

namespace intaglio::formats {
namespace {

using io::PlyElement;
using io::PlyEncoding;
using io::PlyHeader;
using io::PlyProperty;
using io::PlyType;

static_assert(std::endian::native == std::endian::little,
              "big-endian values are reversed for this machine");

/// The values behind the header, one after another. Every PLY type fits in a double.
class PlyValues {
 public:
  virtual ~PlyValues() = default;
  /// Nothing at the end of the bytes or where there is no value of that type.
  virtual std::optional<double> Next(PlyType type) = 0;
};

/// take(T()) with the T of a PLY type.
template <typename Take>
std::optional<double> TakeAs(PlyType type, const Take& take) {
  switch (type) {
    case PlyType::kInt8:
      return take(std::int8_t());
    case PlyType::kUint8:
      return take(std::uint8_t());
    case PlyType::kInt16:
      return take(std::int16_t());
    case PlyType::kUint16:
      return take(std::uint16_t());
    case PlyType::kInt32:
      return take(std::int32_t());
    case PlyType::kUint32:
      return take(std::uint32_t());
    case PlyType::kFloat:
      return take(float());
    case PlyType::kDouble:
      return take(double());
  }
  return std::nullopt;
}

class BinaryValues final : public PlyValues {
 public:
  BinaryValues(std::string_view rest, bool big_endian)
      : rest_(rest), big_endian_(big_endian) {}

  std::optional<double> Next(PlyType type) override {
    return TakeAs(type, [this](auto kind) { return Take<decltype(kind)>(); });
  }

 private:
  template <typename T>
  std::optional<double> Take() {
    std::array<char, sizeof(T)> bytes;
    if (rest_.size() < bytes.size()) return std::nullopt;
    std::memcpy(bytes.data(), rest_.data(), bytes.size());
    rest_.remove_prefix(bytes.size());
    if (big_endian_) std::reverse(bytes.begin(), bytes.end());
    return static_cast<double>(std::bit_cast<T>(bytes));
  }

  std::string_view rest_;
  bool big_endian_;
};

class AsciiValues final : public PlyValues {
 public:
  explicit AsciiValues(std::string_view rest) : rest_(rest) {}

  std::optional<double> Next(PlyType type) override {
    return TakeAs(type, [this]<typename T>(T) {
      if constexpr (std::is_integral_v<T>) {
        return TakeInteger<T>();
      } else {
        return Take<T>();
      }
    });
  }

 private:
  template <typename T>
  std::optional<double> Take() {
    static constexpr std::string_view kBlanks = " \t\r\n";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlanks));
    rest_.remove_prefix(word.size());
    return io::ParseNumber<T>(word);
  }

  // Some writers write integers with a decimal point ("255.0"); whole values in range are
  // accepted.
  template <typename T>
  std::optional<double> TakeInteger() {
    const std::optional<double> value = Take<double>();
    if (!value || *value != std::trunc(*value) ||
        *value < std::numeric_limits<T>::min() ||
        *value > std::numeric_limits<T>::max()) {
      return std::nullopt;
    }
    return value;
  }

  std::string_view rest_;
};

std::unique_ptr<PlyValues> ValuesOf(PlyEncoding encoding, std::string_view rest) {
  if (encoding == PlyEncoding::kAscii) return std::make_unique<AsciiValues>(rest);
  return std::make_unique<BinaryValues>(rest, encoding == PlyEncoding::kBigEndian);
}

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

}  // namespace

Result<PointTable> ParsePly(std::string_view bytes, const PointFileLimits& limits) {
  const PlyHeader header = INTAGLIO_TRY(io::ParsePlyHeader(bytes));
  const std::string_view rest = bytes.substr(header.size);
  const std::unique_ptr<PlyValues> values = ValuesOf(header.encoding, rest);
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
