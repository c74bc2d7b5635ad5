#pragma once

// Files of points: PLY and SCL with any number of named columns, plain XYZ and CFT text,
// and the points of a DXF drawing. docs/formats.md has each format byte by byte. Doubles
// survive a round trip bit for bit in all of them. Points are in the frame of the place
// of use (glass frame for clouds, paths and cracks), mm. point_file_kinds.h picks the
// format by a file's name.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::formats {

/// One value a point. PLY has no 64-bit integers: ticks and the like are stored as
/// double, exact up to 2^53 (at 4 kHz 71 000 years).
struct NamedColumn {
  using Values =
      std::variant<std::vector<double>, std::vector<float>, std::vector<std::int32_t>,
                   std::vector<std::uint32_t>, std::vector<std::uint8_t>>;
  std::string name;  ///< not empty, no white space, not x, y or z; unit in the name
  Values values;     ///< as many as there are points

  bool operator==(const NamedColumn&) const = default;
};

struct PointTable {
  PointList points_mm;  ///< finite
  std::vector<NamedColumn> columns;
  std::vector<std::string> comments;  ///< one line each

  /// The values of a column, or null when there is none of that name and type.
  template <typename T>
  const std::vector<T>* Find(std::string_view name) const {
    for (const NamedColumn& column : columns) {
      if (column.name == name) return std::get_if<std::vector<T>>(&column.values);
    }
    return nullptr;
  }
};

/// Limits on the time and memory of reading; beyond them: ErrorCode::kTooLarge.
struct PointFileLimits {
  std::uint64_t max_file_bytes = std::uint64_t{1} << 30;  ///< 1 GiB
  std::uint64_t max_points = 20'000'000;  ///< ten times the points that a machine
                                          ///< engraves
};

// Writing is atomic (atomic_file.h); errors are those of the disk. A table that breaks
// the rules above is a broken precondition.

/// Binary little-endian PLY: `property double x, y, z`, then the columns in their order
/// as double, float, int, uint or uchar.
Status WritePly(const std::filesystem::path& file, const PointTable& table);

/// Text: the comments, each behind "# ", then "x y z" a line in the shortest decimals
/// that give the same doubles. Columns are left out.
Status WriteXyz(const std::filesystem::path& file, const PointTable& table);

/// Text as other engraving programs take it: "x y z" a line and nothing else, without
/// exponents, lines ended by CR LF. Columns and comments are left out.
Status WriteCft(const std::filesystem::path& file, const PointTable& table);

/// Our own container, with columns and comments, protected by check sums.
Status WriteScl(const std::filesystem::path& file, const PointTable& table);

/// An ASCII DXF of release 12 with a POINT for each point, in mm, on the layer "points".
/// Columns are left out, comments become DXF comments.
Status WriteDxf(const std::filesystem::path& file, const PointTable& table);

// Reading. Errors name the file, the place and the remedy: kNotFound, kIo, kTooLarge,
// kUnreadable (not of the format, or cut off), kMissing (no vertices with x, y and z),
// kInvalidValue (a coordinate is not a finite number).

/// PLY of any kind (ascii, binary of both byte orders). Takes the scalar properties of
/// the element "vertex": x, y, z of any type as the points, the others as columns;
/// integers narrower than 32 bits other than uchar become int. Lists and all other
/// elements (faces) are skipped. "comment" lines become comments.
Result<PointTable> ReadPly(const std::filesystem::path& file,
                           const PointFileLimits& limits = {});

/// Text with three or more numbers per line, separated by blanks, tabs, commas or
/// semicolons; text after the third is skipped. Lines beginning with # are comments,
/// empty lines are skipped. Errors name the line.
Result<PointTable> ReadXyz(const std::filesystem::path& file,
                           const PointFileLimits& limits = {});

// Bytes in memory; errors do not name a file.
Result<PointTable> ParsePly(std::string_view bytes, const PointFileLimits& limits = {});
Result<PointTable> ParseXyz(std::string_view bytes, const PointFileLimits& limits = {});
/// As ParseXyz().
Result<PointTable> ParseCft(std::string_view bytes, const PointFileLimits& limits = {});
/// kUnreadable when cut off or damaged anywhere, kUnsupported when of a newer version.
Result<PointTable> ParseScl(std::string_view bytes, const PointFileLimits& limits = {});
/// The POINT entities of an ASCII DXF's section ENTITIES, in mm by its $INSUNITS (taken
/// for mm where it is absent or 0). All other entities are skipped, and a comment gives
/// their number. kUnsupported: a binary DXF, or a unit that has no place in a block.
Result<PointTable> ParseDxf(std::string_view bytes, const PointFileLimits& limits = {});

}  // namespace intaglio::formats
