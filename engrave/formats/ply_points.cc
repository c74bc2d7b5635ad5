#include "engrave/formats/ply_points.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/try.h"
#include "engrave/formats/ply_vertices.h"
#include "engrave/io/ply_values.h"

namespace intaglio::formats {
namespace {

constexpr std::size_t kMaxHeaderSize = 65536;

/// Up to `size` bytes from `offset` on.
std::string ReadBytes(std::ifstream& in, std::uint64_t offset, std::uint64_t size) {
  in.clear();
  in.seekg(static_cast<std::streamoff>(offset));
  std::string bytes(size, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return bytes;
}

tl::unexpected<Error> Named(const std::string& file, const Error& error) {
  return Fail(error.code, fmt::format("{}: {}", file, error.message), file);
}

/// 0: its rows have no fixed size.
std::uint64_t RowSizeOf(const io::PlyHeader& header) {
  if (header.elements.empty() || header.elements.front().name != "vertex") return 0;
  return RowSize(header.encoding, header.elements.front());
}

}  // namespace

Result<PlyPoints> PlyPoints::Open(const std::filesystem::path& file,
                                  const PointFileLimits& limits) {
  PlyPoints points;
  points.name_ = file.string();
  points.in_.open(file, std::ios::binary);
  if (!points.in_) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{} cannot be opened; check the path", points.name_),
                points.name_);
  }
  const auto header = io::ParsePlyHeader(ReadBytes(points.in_, 0, kMaxHeaderSize));
  if (!header) return Named(points.name_, header.error());
  points.row_size_ = RowSizeOf(*header);
  if (points.row_size_ == 0) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{} is no binary PLY file of points alone; write it again",
                            points.name_),
                points.name_);
  }
  points.encoding_ = header->encoding;
  points.header_size_ = header->size;
  points.vertices_ = header->elements.front();
  if (points.count() > limits.max_points) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{} has {} points, more than the {} allowed", points.name_,
                            points.count(), limits.max_points),
                points.name_);
  }
  return points;
}

Result<PointList> PlyPoints::Next() {
  PointTable table = INTAGLIO_TRY(NextRows());
  return std::move(table.points_mm);
}

Result<PointTable> PlyPoints::NextRows() {
  io::PlyElement piece = vertices_;
  piece.count = std::min(kPieceCount, count() - read_count_);
  if (piece.count == 0) return PointTable();
  const std::string rows =
      ReadBytes(in_, header_size_ + read_count_ * row_size_, piece.count * row_size_);
  auto table = ReadVertices(piece, rows.size(), *io::PlyValuesOf(encoding_, rows), {});
  if (!table) {
    return Named(fmt::format("{}, behind point {}", name_, read_count_), table.error());
  }
  read_count_ += piece.count;
  return table;
}

}  // namespace intaglio::formats
