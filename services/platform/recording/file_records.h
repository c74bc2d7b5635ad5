#pragma once

// Records of a file by their place, with bounds on everything. Inside
// services/platform/recording.

#include <optional>

#include "engrave/core/try.h"
#include "services/platform/recording/byte_source.h"
#include "services/platform/recording/mcap_reader.h"

namespace intaglio::recording {

struct RecordHead {
  Opcode opcode{};
  std::uint64_t offset = 0;          ///< of the record
  std::uint64_t content_length = 0;  ///< the whole record lies in the file
  std::uint64_t content_offset() const { return offset + kRecordHeadSize; }
  std::uint64_t end() const { return content_offset() + content_length; }
};

class FileRecords {
 public:
  FileRecords(const ByteSource& source, const ReaderLimits& limits)
      : source_(source), limits_(limits) {}

  std::uint64_t size() const { return source_.size(); }
  /// Nothing when no whole record lies at this offset.
  Result<std::optional<RecordHead>> HeadAt(std::uint64_t offset) const;
  /// The content, or its first `limit` bytes. kTooLarge beyond the limits.
  Result<Bytes> ContentOf(const RecordHead& head, std::uint64_t limit) const;
  Result<Bytes> ContentOf(const RecordHead& head) const;
  Result<Bytes> Raw(std::uint64_t offset, std::uint64_t length) const;
  /// The record at this offset, of this opcode, decoded. kUnreadable when there is none.
  template <typename Record>
  Result<Record> Get(std::uint64_t offset, Opcode opcode) const {
    auto content = INTAGLIO_TRY(Content(offset, opcode));
    Record record;
    if (!Decode(content, record)) return tl::unexpected(Damaged(offset));
    return record;
  }
  /// The records of the Chunk at this offset.
  Result<Bytes> UnpackedChunk(std::uint64_t offset) const;
  /// With the file, the offset and the remedy.
  Error Damaged(std::uint64_t offset, const std::string& why = "it is damaged") const;

 private:
  Result<Bytes> Content(std::uint64_t offset, Opcode opcode) const;
  const ByteSource& source_;
  ReaderLimits limits_;
};

/// The summary of a complete file; nothing when the file is not complete, or when its
/// summary is damaged or too sparse to read by.
std::optional<RecordingContents> ReadSummary(const FileRecords& file);

/// Behind the end of the data, `data_end`, lies nothing but the mark that the file has no
/// summary (MCAP: summary_start 0), whole.
bool EndsWithoutSummary(const FileRecords& file, std::uint64_t data_end);
/// The same by walking through the file.
Result<RecordingContents> ScanFile(const FileRecords& file);

}  // namespace intaglio::recording
