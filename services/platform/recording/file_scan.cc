// Reading a file that has no summary, record by record.

#include <algorithm>

#include "engrave/core/try.h"
#include "services/platform/recording/chunk_codec.h"
#include "services/platform/recording/file_records.h"

namespace intaglio::recording {
namespace {

// Messages outside chunks are taken together up to this many bytes.
constexpr std::uint64_t kRunBytes = 4u << 20;
// What precedes the content of an attachment: times, name and media type.
constexpr std::uint64_t kAttachmentHead = 1u << 16;

class Scan {
 public:
  explicit Scan(const FileRecords& file) : file_(file) {}

  Result<RecordingContents> Walk() {
    std::uint64_t offset = kMagicSize;
    for (;;) {
      const auto head = INTAGLIO_TRY(file_.HeadAt(offset));
      // A hole that the system filled with zeros is a torn end, too.
      if (!head || head->opcode == Opcode{} || head->opcode == Opcode::kFooter) break;
      if (head->opcode == Opcode::kDataEnd) {
        contents_.complete = EndsWithoutSummary(file_, head->end());
        offset = file_.size();
        break;
      }
      INTAGLIO_TRY(Add(*head));
      offset = head->end();
    }
    contents_.file_bytes = file_.size();
    contents_.torn_bytes = file_.size() - offset;
    CountTables();
    return std::move(contents_);
  }

 private:
  /// An error only when the file cannot be read; what is damaged is noted.
  Status Add(const RecordHead& head) {
    switch (head.opcode) {
      case Opcode::kChunk:
        return AddChunk(head);
      case Opcode::kAttachment:
        return AddAttachment(head);
      case Opcode::kMessage:
      case Opcode::kHeader:
      case Opcode::kSchema:
      case Opcode::kChannel:
      case Opcode::kMetadata:
        break;
      default:
        return {};
    }
    const auto content = file_.ContentOf(head);
    if (!content) return NoteUnlessIo(content.error());
    if (head.opcode == Opcode::kMessage) {
      AddBareMessage(head, *content);
    } else if (head.opcode == Opcode::kMetadata) {
      Metadata metadata;
      if (Decode(*content, metadata)) {
        contents_.metadata.push_back(
            {head.offset, head.end() - head.offset, metadata.name});
      } else {
        Note(head.offset);
      }
    } else if (head.opcode == Opcode::kHeader) {
      if (!Decode(*content, contents_.header)) Note(head.offset);
    } else if (!Define(head.opcode, *content)) {
      Note(head.offset);
    }
    return {};
  }

  bool Define(Opcode opcode, ByteView content) {
    if (opcode == Opcode::kSchema) {
      Schema schema;
      if (!Decode(content, schema)) return false;
      const auto [known, added] = contents_.schemas.emplace(schema.id, schema);
      return added || known->second == schema;
    }
    Channel channel;
    if (!Decode(content, channel)) return false;
    const auto [known, added] = contents_.channels.emplace(channel.id, channel);
    return added || known->second == channel;
  }

  Status AddChunk(const RecordHead& head) {
    const auto records = file_.UnpackedChunk(head.offset);
    if (!records) return NoteUnlessIo(records.error());
    const auto content = INTAGLIO_TRY(file_.ContentOf(head, kAttachmentHead));
    ChunkHead chunk;
    std::size_t head_size = 0;
    if (!DecodeChunkHead(content, chunk, head_size)) return {};
    MessageBlock block{chunk.start_ns,
                       chunk.end_ns,
                       head.offset,
                       head.end() - head.offset,
                       {},
                       chunk.compression,
                       chunk.compressed_size,
                       chunk.uncompressed_size};
    bool good = true;
    const bool whole =
        ForEachRecord(*records, [&](Opcode opcode, ByteView bytes, std::size_t) {
          if (opcode == Opcode::kMessage) {
            MessageView message;
            good = Decode(bytes, message) && good;
            if (good) Count(message, block);
          } else if (opcode == Opcode::kSchema || opcode == Opcode::kChannel) {
            good = Define(opcode, bytes) && good;
          }
          return true;
        });
    if (!good || !whole) Note(head.offset);
    ++contents_.statistics.chunk_count;
    contents_.blocks.push_back(std::move(block));
    return {};
  }

  void AddBareMessage(const RecordHead& head, ByteView content) {
    MessageView message;
    if (!Decode(content, message)) {
      Note(head.offset);
      return;
    }
    auto& blocks = contents_.blocks;
    const bool goes_on = !blocks.empty() && blocks.back().compression == "-" &&
                         blocks.back().offset + blocks.back().length == head.offset &&
                         blocks.back().length < kRunBytes;
    if (!goes_on) {
      blocks.push_back(
          {message.log_time_ns, message.log_time_ns, head.offset, 0, {}, "-", 0, 0});
    }
    MessageBlock& block = blocks.back();
    block.length = head.end() - block.offset;
    block.compressed_size = block.uncompressed_size = block.length;
    block.start_ns = std::min(block.start_ns, message.log_time_ns);
    block.end_ns = std::max(block.end_ns, message.log_time_ns);
    Count(message, block);
  }

  Status AddAttachment(const RecordHead& head) {
    const auto content = INTAGLIO_TRY(file_.ContentOf(head, kAttachmentHead));
    FieldReader in(content);
    AttachmentIndex index{head.offset, head.end() - head.offset, 0, 0, 0, "", ""};
    index.log_time_ns = in.Get<std::uint64_t>();
    index.create_time_ns = in.Get<std::uint64_t>();
    index.name = in.GetText();
    index.media_type = in.GetText();
    index.content_size = in.Get<std::uint64_t>();
    if (in.good()) {
      contents_.attachments.push_back(std::move(index));
    } else {
      Note(head.offset);
    }
    return {};
  }

  void Count(const MessageView& message, MessageBlock& block) {
    Statistics& statistics = contents_.statistics;
    if (statistics.message_count == 0) {
      statistics.start_ns = statistics.end_ns = message.log_time_ns;
    }
    statistics.start_ns = std::min(statistics.start_ns, message.log_time_ns);
    statistics.end_ns = std::max(statistics.end_ns, message.log_time_ns);
    ++statistics.message_count;
    ++statistics.message_counts[message.channel_id];
    auto& channels = block.channels;
    const auto place =
        std::lower_bound(channels.begin(), channels.end(), message.channel_id);
    if (place == channels.end() || *place != message.channel_id) {
      channels.insert(place, message.channel_id);
    }
  }

  void CountTables() {
    Statistics& statistics = contents_.statistics;
    statistics.schema_count = static_cast<std::uint16_t>(contents_.schemas.size());
    statistics.channel_count = static_cast<std::uint32_t>(contents_.channels.size());
    statistics.attachment_count =
        static_cast<std::uint32_t>(contents_.attachments.size());
    statistics.metadata_count = static_cast<std::uint32_t>(contents_.metadata.size());
  }

  void Note(std::uint64_t offset) {
    contents_.damages.push_back(file_.Damaged(offset).message);
  }
  Status NoteUnlessIo(const Error& error) {
    if (error.code == ErrorCode::kIo) return tl::unexpected(error);
    contents_.damages.push_back(error.message);
    return {};
  }

  const FileRecords& file_;
  RecordingContents contents_;
};

}  // namespace

Result<RecordingContents> ScanFile(const FileRecords& file) { return Scan(file).Walk(); }

}  // namespace intaglio::recording
