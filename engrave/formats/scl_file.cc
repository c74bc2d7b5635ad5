// SCL, "sculpture": an array of points, arrays of columns, and two check sums.
//
//   offset  size  (little-endian)
//   0       8     magic 89 'S' 'C' 'L' 0D 0A 1A 0A: a transfer as text damages it
//   8       4     version, 1
//   12      4     header size h, bytes, its check sum included
//   16      8     point count n
//   24      8     unit, mm: what a coordinate of 1 is long; written 1
//   32      4     flags: which of the columns with a meaning of their own there are
//   36      4     column count
//   40      4     comment count
//   44            columns: type (1), length of the name (2), the name
//                 comments: length (4), the text
//   h-4     4     CRC-32 of the bytes 0 .. h-5
//   h       24 n  x, y, z as doubles, point after point
//                 the columns, each n values
//   last    4     CRC-32 of all between h and here
//
// The first 16 bytes and the place of the header's checksum stay the same in every
// version.
//
// Doubles and not fixed-point nanometres: a chain through files must give the path of a
// chain without, bit for bit, and that is what the doubles of every other format do.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/crc32.h"

namespace intaglio::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");
static_assert(sizeof(Vec3) == 24, "points are written as they lie in memory");

constexpr std::string_view kSclMagic = "\x89SCL\r\n\x1a\n";
constexpr std::uint32_t kSclVersion = 1;
constexpr std::size_t kFixedSize = 44;
constexpr std::size_t kCrcSize = 4;
// Bit i of the flags belongs to column i.
constexpr std::array<std::string_view, 4> kFlagged = {"source", "tick", "channel_mask",
                                                      "spacing_mm"};
constexpr std::array<std::size_t, 5> kTypeSizes = {8, 4, 4, 4, 1};
static_assert(std::variant_size_v<NamedColumn::Values> == kTypeSizes.size());

template <typename T>
void Put(T value, std::string& bytes) {
  const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  bytes.append(raw.data(), raw.size());
}

template <typename T>
T GetAt(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::uint32_t Crc(std::string_view bytes, std::uint32_t crc = 0) {
  return io::Crc32(std::as_bytes(std::span(bytes)), crc);
}

template <typename T>
std::string_view BytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::uint32_t FlagOf(std::string_view column) {
  const auto* found = std::find(kFlagged.begin(), kFlagged.end(), column);
  return found == kFlagged.end() ? 0 : 1u << (found - kFlagged.begin());
}

std::string SclHeaderOf(const PointTable& table) {
  std::string header(kSclMagic);
  Put(kSclVersion, header);
  Put(std::uint32_t{0}, header);  // the size, once it is known
  Put(static_cast<std::uint64_t>(table.points_mm.size()), header);
  Put(1.0, header);
  std::uint32_t flags = 0;
  for (const NamedColumn& column : table.columns) flags |= FlagOf(column.name);
  Put(flags, header);
  Put(static_cast<std::uint32_t>(table.columns.size()), header);
  Put(static_cast<std::uint32_t>(table.comments.size()), header);
  for (const NamedColumn& column : table.columns) {
    Require(column.name.size() <= 0xFFFF, "a column's name of {} bytes",
            column.name.size());
    Put(static_cast<std::uint8_t>(column.values.index()), header);
    Put(static_cast<std::uint16_t>(column.name.size()), header);
    header += column.name;
  }
  for (const std::string& comment : table.comments) {
    Put(static_cast<std::uint32_t>(comment.size()), header);
    header += comment;
  }
  Require(header.size() + kCrcSize <= 0xFFFF'FFFF, "{} bytes of columns and comments",
          header.size());
  const auto size = static_cast<std::uint32_t>(header.size() + kCrcSize);
  std::memcpy(header.data() + 12, &size, sizeof size);
  Put(Crc(header), header);
  return header;
}

tl::unexpected<Error> Damaged(std::string_view what) {
  return Fail(ErrorCode::kUnreadable, fmt::format("{}; write or copy it again", what));
}

struct Column {
  std::string name;
  std::size_t type = 0;
};

struct SclHeader {
  std::size_t size = 0;
  std::uint64_t point_count = 0;
  double unit_mm = 1;
  std::vector<Column> columns;
  std::vector<std::string> comments;
};

bool MayNameAColumn(std::string_view name) {
  return !name.empty() && name != "x" && name != "y" && name != "z" &&
         name.find_first_of(" \t\r\n") == std::string_view::npos;
}

/// Reads the variable parts of the header one after another. False where it ends too
/// early or holds something that is not allowed in a table.
class HeaderParts {
 public:
  explicit HeaderParts(std::string_view rest) : rest_(rest) {}

  bool TakeColumn(Column& column) {
    if (rest_.size() < 3) return false;
    column.type = static_cast<std::uint8_t>(rest_[0]);
    const std::size_t length = GetAt<std::uint16_t>(rest_, 1);
    rest_.remove_prefix(3);
    return column.type < kTypeSizes.size() && TakeText(length, column.name) &&
           MayNameAColumn(column.name);
  }
  bool TakeComment(std::string& comment) {
    if (rest_.size() < 4) return false;
    const std::size_t length = GetAt<std::uint32_t>(rest_, 0);
    rest_.remove_prefix(4);
    return TakeText(length, comment) &&
           comment.find_first_of("\r\n") == std::string::npos;
  }
  bool empty() const { return rest_.empty(); }

 private:
  bool TakeText(std::size_t length, std::string& text) {
    if (rest_.size() < length) return false;
    text = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return true;
  }

  std::string_view rest_;
};

/// Reads the header behind its checksum, which has been verified.
Result<SclHeader> ParseParts(std::string_view bytes, std::size_t size) {
  SclHeader header;
  header.size = size;
  header.point_count = GetAt<std::uint64_t>(bytes, 16);
  header.unit_mm = GetAt<double>(bytes, 24);
  if (!std::isfinite(header.unit_mm) || header.unit_mm <= 0) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("its unit is {} mm, which is not a valid length; write it again",
                    header.unit_mm));
  }
  HeaderParts parts(bytes.substr(kFixedSize, size - kCrcSize - kFixedSize));
  std::uint32_t flags = 0;
  for (auto left = GetAt<std::uint32_t>(bytes, 36); left > 0; --left) {
    if (!parts.TakeColumn(header.columns.emplace_back())) {
      return Damaged("its list of columns is damaged");
    }
    flags |= FlagOf(header.columns.back().name);
  }
  for (auto left = GetAt<std::uint32_t>(bytes, 40); left > 0; --left) {
    if (!parts.TakeComment(header.comments.emplace_back())) {
      return Damaged("its comments are damaged");
    }
  }
  if (!parts.empty() || flags != GetAt<std::uint32_t>(bytes, 32)) {
    return Damaged("its header is inconsistent");
  }
  return header;
}

Result<SclHeader> ParseHeader(std::string_view bytes) {
  if (!bytes.starts_with(kSclMagic.substr(0, 4))) {
    return Fail(ErrorCode::kUnreadable,
                "it is not an SCL of this program, whose first bytes are 89 53 43 4C; "
                "export the points as CFT or XYZ text instead");
  }
  if (bytes.size() < kFixedSize + kCrcSize) return Damaged("the file is truncated");
  if (!bytes.starts_with(kSclMagic)) {
    return Damaged("its line ends were changed, as by a transfer in text mode");
  }
  const std::size_t size = GetAt<std::uint32_t>(bytes, 12);
  if (size < kFixedSize + kCrcSize) return Damaged("its header is damaged");
  if (size > bytes.size())
    return Damaged("the file is truncated, or its header is damaged");
  if (Crc(bytes.substr(0, size - kCrcSize)) !=
      GetAt<std::uint32_t>(bytes, size - kCrcSize)) {
    return Damaged("its header is damaged");
  }
  const auto version = GetAt<std::uint32_t>(bytes, 8);
  if (version != kSclVersion) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("it has version {}, this program reads {}; use the program "
                            "that wrote it, or export XYZ",
                            version, kSclVersion),
                fmt::format("{}", version));
  }
  return ParseParts(bytes, size);
}

/// The bytes behind the header, whole and undamaged, without their check sum.
Result<std::string_view> PayloadOf(std::string_view bytes, const SclHeader& header) {
  std::size_t row_size = sizeof(Vec3);
  for (const Column& column : header.columns) row_size += kTypeSizes[column.type];
  const std::string_view rest = bytes.substr(header.size);
  // The size by multiplication could overflow; a count that fits in the rest does not.
  if (header.point_count > rest.size() / row_size ||
      header.point_count * row_size + kCrcSize > rest.size()) {
    return Damaged(fmt::format("the file is truncated: its {} {} more than its {}",
                               Counted(header.point_count, "point"),
                               VerbFor(header.point_count, "needs", "need"),
                               Counted(bytes.size(), "byte")));
  }
  const std::size_t size = header.point_count * row_size;
  if (rest.size() > size + kCrcSize) {
    return Damaged(
        fmt::format("{} {} its {}", Counted(rest.size() - size - kCrcSize, "extra byte"),
                    VerbFor(rest.size() - size - kCrcSize, "follows", "follow"),
                    Counted(header.point_count, "point")));
  }
  if (Crc(rest.substr(0, size)) != GetAt<std::uint32_t>(rest, size)) {
    return Damaged("its points are damaged: their checksum is wrong");
  }
  return rest.substr(0, size);
}

template <typename T>
std::vector<T> TakeValues(std::string_view& payload, std::uint64_t count) {
  std::vector<T> values(count);
  auto* bytes = reinterpret_cast<char*>(values.data());
  std::copy_n(payload.data(), count * sizeof(T), bytes);
  payload.remove_prefix(count * sizeof(T));
  return values;
}

NamedColumn::Values TakeColumn(std::string_view& payload, std::size_t type,
                               std::uint64_t count) {
  switch (type) {
    case 0:
      return TakeValues<double>(payload, count);
    case 1:
      return TakeValues<float>(payload, count);
    case 2:
      return TakeValues<std::int32_t>(payload, count);
    case 3:
      return TakeValues<std::uint32_t>(payload, count);
    default:
      return TakeValues<std::uint8_t>(payload, count);
  }
}

}  // namespace

Status WriteScl(const std::filesystem::path& file, const PointTable& table) {
  RequireWritable(table);
  io::AtomicFile out = INTAGLIO_TRY(io::AtomicFile::Create(file));
  INTAGLIO_TRY(out.Write(SclHeaderOf(table)));
  std::uint32_t crc = 0;
  const auto write = [&](std::string_view bytes) {
    crc = Crc(bytes, crc);
    return out.Write(bytes);
  };
  INTAGLIO_TRY(write(BytesOf(table.points_mm)));
  for (const NamedColumn& column : table.columns) {
    const Status status = std::visit(
        [&](const auto& values) { return write(BytesOf(values)); }, column.values);
    if (!status) return status;
  }
  std::string trailer;
  Put(crc, trailer);
  INTAGLIO_TRY(out.Write(trailer));
  return out.Commit();
}

Result<PointTable> ParseScl(std::string_view bytes, const PointFileLimits& limits) {
  SclHeader header = INTAGLIO_TRY(ParseHeader(bytes));
  if (header.point_count > limits.max_points) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("it has {} points, more than the {} allowed; thin it out or "
                            "raise the limit",
                            header.point_count, limits.max_points));
  }
  std::string_view payload = INTAGLIO_TRY(PayloadOf(bytes, header));
  PointTable table;
  table.points_mm = TakeValues<Vec3>(payload, header.point_count);
  for (std::size_t i = 0; i < table.points_mm.size(); ++i) {
    Vec3& p = table.points_mm[i];
    if (header.unit_mm != 1) p *= header.unit_mm;
    if (p.allFinite()) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("point {} is at ({}, {}, {}), which is not finite; write the "
                            "file again without it",
                            i + 1, p.x(), p.y(), p.z()));
  }
  for (Column& column : header.columns) {
    table.columns.push_back(
        {std::move(column.name), TakeColumn(payload, column.type, header.point_count)});
  }
  table.comments = std::move(header.comments);
  return table;
}

}  // namespace intaglio::formats
