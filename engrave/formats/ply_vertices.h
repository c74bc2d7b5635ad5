#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/formats/point_file.h"
#include "engrave/io/ply_header.h"
#include "engrave/io/ply_values.h"

namespace intaglio::formats {

/// Reads the rows of an element "vertex" as points and columns, all at once or some at a
/// time. Errors as ParsePly(), of the rows counted from the first that is read.
class PlyVertices {
 public:
  /// `rest_size`: bytes that all rows and what follows them have.
  static Result<PlyVertices> Begin(const io::PlyElement& vertices, std::size_t rest_size,
                                   const PointFileLimits& limits);

  /// Reads that many more rows, or as many as are left. kUnreadable: `values` ends.
  Status Read(std::uint64_t row_count, io::PlyValues& values);
  bool complete() const { return read_count_ == vertices_.count; }
  /// All rows are read. kUnreadable: they are not. kInvalidValue: a coordinate is not
  /// finite.
  Result<PointTable> Finish();

 private:
  explicit PlyVertices(const io::PlyElement& vertices) : vertices_(vertices) {}

  io::PlyElement vertices_;
  std::array<std::size_t, 3> coordinates_{};  ///< among the properties
  std::uint64_t read_count_ = 0;
  PointList points_mm_;
  std::vector<NamedColumn> columns_;  ///< one a property; of a list or coordinate empty
};

/// The rows as points and columns, all at once.
Result<PointTable> ReadVertices(const io::PlyElement& vertices, std::size_t rest_size,
                                io::PlyValues& values, const PointFileLimits& limits);

/// Bytes of a row of an element in a binary file; 0: it has lists, or the file is text.
std::uint64_t RowSize(io::PlyEncoding encoding, const io::PlyElement& element);

}  // namespace intaglio::formats
