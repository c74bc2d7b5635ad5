#include "services/platform/recording/file_records.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/try.h"
#include "services/platform/recording/chunk_codec.h"

namespace intaglio::recording {

Error FileRecords::Damaged(std::uint64_t offset, const std::string& why) const {
  return {ErrorCode::kUnreadable,
          fmt::format("{}: the record at byte {}: {}; `intaglio recording repair` keeps "
                      "the rest",
                      source_.name(), offset, why),
          std::to_string(offset)};
}

Result<std::optional<RecordHead>> FileRecords::HeadAt(std::uint64_t offset) const {
  if (offset > size() || size() - offset < kRecordHeadSize) return std::nullopt;
  std::byte raw[kRecordHeadSize];
  INTAGLIO_TRY(source_.Read(offset, raw));
  FieldReader in(raw);
  RecordHead head;
  head.opcode = static_cast<Opcode>(in.Get<std::uint8_t>());
  head.offset = offset;
  head.content_length = in.Get<std::uint64_t>();
  if (head.content_length > size() - head.content_offset()) return std::nullopt;
  return head;
}

Result<Bytes> FileRecords::Raw(std::uint64_t offset, std::uint64_t length) const {
  if (offset > size() || length > size() - offset) {
    return tl::unexpected(Damaged(offset, "it reaches beyond the end of the file"));
  }
  if (length > limits_.max_record_bytes) {
    Error error =
        Damaged(offset, fmt::format("{} bytes, more than the {} that can be read at once",
                                    length, limits_.max_record_bytes));
    error.code = ErrorCode::kTooLarge;
    return tl::unexpected(error);
  }
  Bytes bytes(static_cast<std::size_t>(length));
  INTAGLIO_TRY(source_.Read(offset, bytes));
  return bytes;
}

Result<Bytes> FileRecords::ContentOf(const RecordHead& head, std::uint64_t limit) const {
  return Raw(head.content_offset(), std::min(head.content_length, limit));
}

Result<Bytes> FileRecords::ContentOf(const RecordHead& head) const {
  return ContentOf(head, head.content_length);
}

Result<Bytes> FileRecords::Content(std::uint64_t offset, Opcode opcode) const {
  auto head = INTAGLIO_TRY(HeadAt(offset));
  if (!head || head->opcode != opcode) {
    return tl::unexpected(Damaged(offset, "it does not match the summary"));
  }
  return ContentOf(*head);
}

Result<Bytes> FileRecords::UnpackedChunk(std::uint64_t offset) const {
  const auto content = INTAGLIO_TRY(Content(offset, Opcode::kChunk));
  ChunkHead head;
  std::size_t head_size = 0;
  if (!DecodeChunkHead(content, head, head_size) ||
      head.compressed_size > content.size() - head_size) {
    return tl::unexpected(Damaged(offset));
  }
  const ByteView packed = ByteView(content).subspan(
      head_size, static_cast<std::size_t>(head.compressed_size));
  return UnpackChunk(head, packed, limits_.max_record_bytes)
      .map_error([&](const Error& error) {
        Error named = Damaged(offset, error.message);
        named.code = error.code;
        return named;
      });
}

}  // namespace intaglio::recording
