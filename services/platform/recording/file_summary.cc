// Reading by the summary: Footer, then the records between summary_start and the offsets.

#include <algorithm>

#include "engrave/io/crc32.h"
#include "services/platform/recording/chunk_codec.h"
#include "services/platform/recording/file_records.h"

namespace intaglio::recording {
namespace {

constexpr std::uint64_t kFooterContent = 20;
constexpr std::uint64_t kEndSize = kRecordHeadSize + kFooterContent + kMagicSize;

template <typename Record>
bool Keep(ByteView content, std::vector<Record>& list) {
  return Decode(content, list.emplace_back());
}

MessageBlock BlockOf(const ChunkIndex& index) {
  MessageBlock block{
      index.start_ns,    index.end_ns,          index.offset,           index.length, {},
      index.compression, index.compressed_size, index.uncompressed_size};
  for (const auto& [channel, offset] : index.message_index_offsets) {
    block.channels.push_back(channel);
  }
  return block;
}

class Summary {
 public:
  bool Add(Opcode opcode, ByteView content) {
    switch (opcode) {
      case Opcode::kSchema: {
        Schema schema;
        if (!Decode(content, schema)) return false;
        contents.schemas.emplace(schema.id, std::move(schema));
        return true;
      }
      case Opcode::kChannel: {
        Channel channel;
        if (!Decode(content, channel)) return false;
        contents.channels.emplace(channel.id, std::move(channel));
        return true;
      }
      case Opcode::kChunkIndex: {
        ChunkIndex index;
        if (!Decode(content, index)) return false;
        contents.blocks.push_back(BlockOf(index));
        return true;
      }
      case Opcode::kStatistics:
        has_statistics_ = true;
        return Decode(content, contents.statistics);
      case Opcode::kAttachmentIndex:
        return Keep(content, contents.attachments);
      case Opcode::kMetadataIndex:
        return Keep(content, contents.metadata);
      default:
        return true;
    }
  }

  /// A writer may leave out any part of its summary; then the file has to be walked.
  bool Suffices() const {
    const Statistics& reported = contents.statistics;
    return has_statistics_ && contents.blocks.size() == reported.chunk_count &&
           (reported.chunk_count > 0 || reported.message_count == 0) &&
           contents.channels.size() == reported.channel_count &&
           contents.schemas.size() == reported.schema_count &&
           contents.attachments.size() == reported.attachment_count &&
           contents.metadata.size() == reported.metadata_count;
  }

  RecordingContents contents;

 private:
  bool has_statistics_ = false;
};

}  // namespace

bool EndsWithoutSummary(const FileRecords& file, std::uint64_t data_end) {
  if (data_end > file.size() || file.size() - data_end != kEndSize) return false;
  const auto magic = file.Raw(file.size() - kMagicSize, kMagicSize);
  const auto footer = file.Get<Footer>(data_end, Opcode::kFooter);
  return magic && std::memcmp(magic->data(), kMagic, kMagicSize) == 0 && footer &&
         footer->summary_start == 0;
}

std::optional<RecordingContents> ReadSummary(const FileRecords& file) {
  if (file.size() < kEndSize) return std::nullopt;
  const std::uint64_t footer_at = file.size() - kEndSize;
  const auto magic = file.Raw(file.size() - kMagicSize, kMagicSize);
  if (!magic || std::memcmp(magic->data(), kMagic, kMagicSize) != 0) return std::nullopt;
  const auto footer = file.Get<Footer>(footer_at, Opcode::kFooter);
  if (!footer || footer->summary_start < kMagicSize || footer->summary_start > footer_at)
    return std::nullopt;
  const std::uint64_t crc_at = footer_at + kRecordHeadSize + kFooterContent - 4;
  const auto covered = file.Raw(footer->summary_start, crc_at - footer->summary_start);
  if (!covered ||
      (footer->summary_crc != 0 && footer->summary_crc != io::Crc32(*covered)))
    return std::nullopt;
  Summary summary;
  bool good = true;
  const auto records = ByteView(*covered).first(
      static_cast<std::size_t>(footer_at - footer->summary_start));
  const bool whole =
      ForEachRecord(records, [&](Opcode opcode, ByteView content, std::size_t) {
        good = summary.Add(opcode, content);
        return good;
      });
  const auto header = file.Get<Header>(kMagicSize, Opcode::kHeader);
  if (!good || !whole || !header || !summary.Suffices()) return std::nullopt;
  auto& blocks = summary.contents.blocks;
  std::sort(blocks.begin(), blocks.end(),
            [](const auto& a, const auto& b) { return a.offset < b.offset; });
  summary.contents.header = *header;
  summary.contents.file_bytes = file.size();
  summary.contents.complete = true;
  return std::move(summary.contents);
}

}  // namespace intaglio::recording
