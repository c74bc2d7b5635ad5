#include "services/platform/recording/chunk_codec.h"

#include <fmt/format.h>
#include <zstd.h>

#include "engrave/core/check.h"
#include "engrave/io/crc32.h"

namespace intaglio::recording {

ChunkCompressor::ChunkCompressor(int level) : context_(ZSTD_createCCtx()), level_(level) {
  Require(context_ != nullptr, "no memory for zstd at level {}", level);
}

ChunkCompressor::~ChunkCompressor() { ZSTD_freeCCtx(context_); }

ByteView ChunkCompressor::Compress(ByteView records) {
  out_.resize(ZSTD_compressBound(records.size()));
  const std::size_t size = ZSTD_compressCCtx(context_, out_.data(), out_.size(),
                                             records.data(), records.size(), level_);
  Require(ZSTD_isError(size) == 0, "zstd: {}", ZSTD_getErrorName(size));
  return ByteView(out_).first(size);
}

Result<Bytes> UnpackChunk(const ChunkHead& head, ByteView packed,
                          std::uint64_t max_bytes) {
  if (head.uncompressed_size > max_bytes) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("has {} bytes, more than the {} that can be read at once",
                            head.uncompressed_size, max_bytes),
                std::to_string(head.uncompressed_size));
  }
  Bytes records;
  if (head.compression.empty()) {
    records.assign(packed.begin(), packed.end());
  } else if (head.compression == kZstd) {
    // Check the frame's own size first: no storage is allocated for a size that only the
    // head claims.
    const auto reported = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (reported == ZSTD_CONTENTSIZE_ERROR ||
        (reported != ZSTD_CONTENTSIZE_UNKNOWN && reported != head.uncompressed_size)) {
      return Fail(ErrorCode::kUnreadable, "is not a zstd frame of the expected size");
    }
    records.resize(static_cast<std::size_t>(head.uncompressed_size));
    const std::size_t size =
        ZSTD_decompress(records.data(), records.size(), packed.data(), packed.size());
    if (ZSTD_isError(size) != 0) {
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("cannot be unpacked: {}", ZSTD_getErrorName(size)));
    }
    records.resize(size);
  } else {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("is compressed with \"{}\"; only zstd is read: convert it with "
                    "`mcap compress --compression zstd`",
                    head.compression),
        head.compression);
  }
  if (records.size() != head.uncompressed_size ||
      (head.uncompressed_crc != 0 && io::Crc32(records) != head.uncompressed_crc)) {
    return Fail(ErrorCode::kUnreadable, "its checksum is wrong: it is damaged");
  }
  return records;
}

}  // namespace intaglio::recording
