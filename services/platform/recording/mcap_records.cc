#include "services/platform/recording/mcap_records.h"

#include "engrave/io/crc32.h"

namespace intaglio::recording {
namespace {

/// Begins a record; its length is known when it ends.
class RecordScope {
 public:
  RecordScope(Bytes& out, Opcode opcode) : out_(out) {
    Put(out_, static_cast<std::uint8_t>(opcode));
    begin_ = out_.size();
    Put<std::uint64_t>(out_, 0);
  }
  ~RecordScope() {
    const std::uint64_t length = out_.size() - begin_ - sizeof length;
    std::memcpy(out_.data() + begin_, &length, sizeof length);
  }
  RecordScope(const RecordScope&) = delete;
  RecordScope& operator=(const RecordScope&) = delete;
  std::size_t content_begin() const { return begin_ + sizeof(std::uint64_t); }

 private:
  Bytes& out_;
  std::size_t begin_;
};

void PutNumbers(Bytes& out, const std::map<std::uint16_t, std::uint64_t>& numbers) {
  Put(out, static_cast<std::uint32_t>(numbers.size() * 10));
  for (const auto& [key, value] : numbers) {
    Put(out, key);
    Put(out, value);
  }
}

bool GetNumbers(FieldReader& in, std::map<std::uint16_t, std::uint64_t>& numbers) {
  FieldReader entries(in.GetRaw(in.Get<std::uint32_t>()));
  while (entries.good() && entries.left() > 0) {
    const auto key = entries.Get<std::uint16_t>();
    numbers[key] = entries.Get<std::uint64_t>();
  }
  return in.good() && entries.good();
}

}  // namespace

const char kMagic[kMagicSize + 1] = "\x89MCAP0\r\n";

void Encode(Bytes& out, const Header& record) {
  const RecordScope scope(out, Opcode::kHeader);
  PutText(out, record.profile);
  PutText(out, record.library);
}

bool Decode(ByteView content, Header& record) {
  FieldReader in(content);
  record.profile = in.GetText();
  record.library = in.GetText();
  return in.good();
}

void Encode(Bytes& out, const Footer& record) {
  const RecordScope scope(out, Opcode::kFooter);
  Put(out, record.summary_start);
  Put(out, record.summary_offset_start);
  Put(out, record.summary_crc);
}

bool Decode(ByteView content, Footer& record) {
  FieldReader in(content);
  record.summary_start = in.Get<std::uint64_t>();
  record.summary_offset_start = in.Get<std::uint64_t>();
  record.summary_crc = in.Get<std::uint32_t>();
  return in.good();
}

void Encode(Bytes& out, const Schema& record) {
  const RecordScope scope(out, Opcode::kSchema);
  Put(out, record.id);
  PutText(out, record.name);
  PutText(out, record.encoding);
  PutText(out, record.text);
}

bool Decode(ByteView content, Schema& record) {
  FieldReader in(content);
  record.id = in.Get<std::uint16_t>();
  record.name = in.GetText();
  record.encoding = in.GetText();
  record.text = in.GetText();
  return in.good() && record.id != 0;
}

void Encode(Bytes& out, const Channel& record) {
  const RecordScope scope(out, Opcode::kChannel);
  Put(out, record.id);
  Put(out, record.schema_id);
  PutText(out, record.topic);
  PutText(out, record.message_encoding);
  PutMap(out, record.metadata);
}

bool Decode(ByteView content, Channel& record) {
  FieldReader in(content);
  record.id = in.Get<std::uint16_t>();
  record.schema_id = in.Get<std::uint16_t>();
  record.topic = in.GetText();
  record.message_encoding = in.GetText();
  record.metadata = in.GetMap();
  return in.good();
}

void Encode(Bytes& out, const MessageView& record) {
  const RecordScope scope(out, Opcode::kMessage);
  Put(out, record.channel_id);
  Put(out, record.sequence);
  Put(out, record.log_time_ns);
  Put(out, record.publish_time_ns);
  PutRaw(out, record.payload);
}

bool Decode(ByteView content, MessageView& record) {
  FieldReader in(content);
  record.channel_id = in.Get<std::uint16_t>();
  record.sequence = in.Get<std::uint32_t>();
  record.log_time_ns = in.Get<std::uint64_t>();
  record.publish_time_ns = in.Get<std::uint64_t>();
  record.payload = in.GetRest();
  return in.good();
}

void EncodeChunkHead(Bytes& out, const ChunkHead& head) {
  Put(out, static_cast<std::uint8_t>(Opcode::kChunk));
  Put<std::uint64_t>(out, 40 + head.compression.size() + head.compressed_size);
  Put(out, head.start_ns);
  Put(out, head.end_ns);
  Put(out, head.uncompressed_size);
  Put(out, head.uncompressed_crc);
  PutText(out, head.compression);
  Put(out, head.compressed_size);
}

bool DecodeChunkHead(ByteView content, ChunkHead& head, std::size_t& head_size) {
  FieldReader in(content);
  head.start_ns = in.Get<std::uint64_t>();
  head.end_ns = in.Get<std::uint64_t>();
  head.uncompressed_size = in.Get<std::uint64_t>();
  head.uncompressed_crc = in.Get<std::uint32_t>();
  head.compression = in.GetText();
  head.compressed_size = in.Get<std::uint64_t>();
  head_size = in.at();
  return in.good();
}

void Encode(Bytes& out, const MessageIndex& record) {
  const RecordScope scope(out, Opcode::kMessageIndex);
  Put(out, record.channel_id);
  Put(out, static_cast<std::uint32_t>(record.entries.size() * 16));
  for (const MessageIndex::Entry& entry : record.entries) {
    Put(out, entry.log_time_ns);
    Put(out, entry.offset);
  }
}

bool Decode(ByteView content, MessageIndex& record) {
  FieldReader in(content);
  record.channel_id = in.Get<std::uint16_t>();
  FieldReader entries(in.GetRaw(in.Get<std::uint32_t>()));
  while (entries.good() && entries.left() > 0) {
    const auto log_time_ns = entries.Get<std::uint64_t>();
    record.entries.push_back({log_time_ns, entries.Get<std::uint64_t>()});
  }
  return in.good() && entries.good();
}

void Encode(Bytes& out, const ChunkIndex& record) {
  const RecordScope scope(out, Opcode::kChunkIndex);
  Put(out, record.start_ns);
  Put(out, record.end_ns);
  Put(out, record.offset);
  Put(out, record.length);
  PutNumbers(out, record.message_index_offsets);
  Put(out, record.message_index_length);
  PutText(out, record.compression);
  Put(out, record.compressed_size);
  Put(out, record.uncompressed_size);
}

bool Decode(ByteView content, ChunkIndex& record) {
  FieldReader in(content);
  record.start_ns = in.Get<std::uint64_t>();
  record.end_ns = in.Get<std::uint64_t>();
  record.offset = in.Get<std::uint64_t>();
  record.length = in.Get<std::uint64_t>();
  if (!GetNumbers(in, record.message_index_offsets)) return false;
  record.message_index_length = in.Get<std::uint64_t>();
  record.compression = in.GetText();
  record.compressed_size = in.Get<std::uint64_t>();
  record.uncompressed_size = in.Get<std::uint64_t>();
  return in.good();
}

void Encode(Bytes& out, const Attachment& record) {
  const RecordScope scope(out, Opcode::kAttachment);
  Put(out, record.log_time_ns);
  Put(out, record.create_time_ns);
  PutText(out, record.name);
  PutText(out, record.media_type);
  Put<std::uint64_t>(out, record.content.size());
  PutRaw(out, record.content);
  Put(out, io::Crc32(ByteView(out).subspan(scope.content_begin())));
}

bool Decode(ByteView content, Attachment& record) {
  FieldReader in(content);
  record.log_time_ns = in.Get<std::uint64_t>();
  record.create_time_ns = in.Get<std::uint64_t>();
  record.name = in.GetText();
  record.media_type = in.GetText();
  const ByteView bytes = in.GetRaw(in.Get<std::uint64_t>());
  record.content.assign(bytes.begin(), bytes.end());
  const std::size_t covered = in.at();
  const auto crc = in.Get<std::uint32_t>();
  return in.good() && (crc == 0 || crc == io::Crc32(content.first(covered)));
}

void Encode(Bytes& out, const AttachmentIndex& record) {
  const RecordScope scope(out, Opcode::kAttachmentIndex);
  Put(out, record.offset);
  Put(out, record.length);
  Put(out, record.log_time_ns);
  Put(out, record.create_time_ns);
  Put(out, record.content_size);
  PutText(out, record.name);
  PutText(out, record.media_type);
}

bool Decode(ByteView content, AttachmentIndex& record) {
  FieldReader in(content);
  record.offset = in.Get<std::uint64_t>();
  record.length = in.Get<std::uint64_t>();
  record.log_time_ns = in.Get<std::uint64_t>();
  record.create_time_ns = in.Get<std::uint64_t>();
  record.content_size = in.Get<std::uint64_t>();
  record.name = in.GetText();
  record.media_type = in.GetText();
  return in.good();
}

void Encode(Bytes& out, const Statistics& record) {
  const RecordScope scope(out, Opcode::kStatistics);
  Put(out, record.message_count);
  Put(out, record.schema_count);
  Put(out, record.channel_count);
  Put(out, record.attachment_count);
  Put(out, record.metadata_count);
  Put(out, record.chunk_count);
  Put(out, record.start_ns);
  Put(out, record.end_ns);
  PutNumbers(out, record.message_counts);
}

bool Decode(ByteView content, Statistics& record) {
  FieldReader in(content);
  record.message_count = in.Get<std::uint64_t>();
  record.schema_count = in.Get<std::uint16_t>();
  record.channel_count = in.Get<std::uint32_t>();
  record.attachment_count = in.Get<std::uint32_t>();
  record.metadata_count = in.Get<std::uint32_t>();
  record.chunk_count = in.Get<std::uint32_t>();
  record.start_ns = in.Get<std::uint64_t>();
  record.end_ns = in.Get<std::uint64_t>();
  return GetNumbers(in, record.message_counts);
}

void Encode(Bytes& out, const Metadata& record) {
  const RecordScope scope(out, Opcode::kMetadata);
  PutText(out, record.name);
  PutMap(out, record.entries);
}

bool Decode(ByteView content, Metadata& record) {
  FieldReader in(content);
  record.name = in.GetText();
  record.entries = in.GetMap();
  return in.good();
}

void Encode(Bytes& out, const MetadataIndex& record) {
  const RecordScope scope(out, Opcode::kMetadataIndex);
  Put(out, record.offset);
  Put(out, record.length);
  PutText(out, record.name);
}

bool Decode(ByteView content, MetadataIndex& record) {
  FieldReader in(content);
  record.offset = in.Get<std::uint64_t>();
  record.length = in.Get<std::uint64_t>();
  record.name = in.GetText();
  return in.good();
}

void EncodeSummaryOffset(Bytes& out, Opcode group, std::uint64_t start,
                         std::uint64_t length) {
  const RecordScope scope(out, Opcode::kSummaryOffset);
  Put(out, static_cast<std::uint8_t>(group));
  Put(out, start);
  Put(out, length);
}

void EncodeDataEnd(Bytes& out, std::uint32_t crc) {
  const RecordScope scope(out, Opcode::kDataEnd);
  Put(out, crc);
}

}  // namespace intaglio::recording
