#pragma once

// The points of a binary PLY file piece by piece, for programs that may not hold all of
// them: what is in memory is one piece.

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "engrave/formats/point_file.h"
#include "engrave/io/ply_header.h"

namespace intaglio::formats {

class PlyPoints {
 public:
  /// As many points are in memory at a time.
  static constexpr std::uint64_t kPieceCount = 16384;

  /// Errors as ReadPly(); kUnsupported: a file that WritePly() does not write (text, or
  /// points behind lists or other elements).
  static Result<PlyPoints> Open(const std::filesystem::path& file,
                                const PointFileLimits& limits = {});

  std::uint64_t count() const { return vertices_.count; }
  /// The next points, mm; empty behind the last. kUnreadable: the file is cut off.
  /// kInvalidValue: a coordinate is not finite.
  Result<PointList> Next();
  /// The same with their other columns.
  Result<PointTable> NextRows();
  /// The next call begins with the first point again.
  void Rewind() { read_count_ = 0; }

 private:
  PlyPoints() = default;

  std::string name_;  // of the file, for errors
  std::ifstream in_;
  io::PlyEncoding encoding_ = io::PlyEncoding::kLittleEndian;
  io::PlyElement vertices_;
  std::uint64_t header_size_ = 0, row_size_ = 0, read_count_ = 0;
};

}  // namespace intaglio::formats
