#pragma once

// Compression of chunks, and the records in them.

#include <cstdint>
#include <string>

#include "engrave/core/result.h"
#include "services/platform/recording/mcap_records.h"

struct ZSTD_CCtx_s;

namespace intaglio::recording {

inline constexpr char kZstd[] = "zstd";

/// Compresses with zstd; keeps its tables from one chunk to the next. From one thread.
class ChunkCompressor {
 public:
  /// Level of zstd, -7..19. 1 compresses points at some 300 MB/s on one core.
  explicit ChunkCompressor(int level);
  ~ChunkCompressor();
  ChunkCompressor(const ChunkCompressor&) = delete;
  ChunkCompressor& operator=(const ChunkCompressor&) = delete;
  /// The compressed bytes, valid until the next call.
  ByteView Compress(ByteView records);

 private:
  ZSTD_CCtx_s* context_;
  int level_;
  Bytes out_;
};

/// The records of a chunk whose CRC holds. kUnreadable, kUnsupported (a compression that
/// is not known) or kTooLarge (more than `max_bytes` unpacked), without file and offset.
Result<Bytes> UnpackChunk(const ChunkHead& head, ByteView packed,
                          std::uint64_t max_bytes);

/// Calls visit(opcode, content, offset of the record) for one record after another while
/// visit returns true. False when the bytes end within a record.
template <typename Visit>
bool ForEachRecord(ByteView bytes, Visit&& visit) {
  FieldReader in(bytes);
  while (in.left() > 0) {
    const std::size_t offset = in.at();
    const auto opcode = static_cast<Opcode>(in.Get<std::uint8_t>());
    const ByteView content = in.GetRaw(in.Get<std::uint64_t>());
    if (!in.good()) return false;
    if (!visit(opcode, content, offset)) return true;
  }
  return true;
}

}  // namespace intaglio::recording
