#include "services/platform/recording/mcap_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/crc32.h"
#include "services/platform/recording/append_file.h"
#include "services/platform/recording/chunk_codec.h"

namespace intaglio::recording {

namespace {

/// A chunk that gathers.
struct Gathered {
  Bytes records;
  ChunkHead head;
  std::map<std::uint16_t, MessageIndex> indexes;

  void Add(const MessageView& message) {
    if (records.empty()) head.start_ns = head.end_ns = message.log_time_ns;
    head.start_ns = std::min(head.start_ns, message.log_time_ns);
    head.end_ns = std::max(head.end_ns, message.log_time_ns);
    MessageIndex& index = indexes[message.channel_id];
    index.channel_id = message.channel_id;
    index.entries.push_back({message.log_time_ns, records.size()});
    Encode(records, message);
  }
  void Clear() {
    records.clear();
    indexes.clear();
    head = {};
  }
};

}  // namespace

struct McapWriter::Impl {
  Impl(AppendFile&& target, const WriterOptions& given)
      : file(std::move(target)), options(given), compressor(given.compression_level) {}

  template <typename Record>
  Status Append(const Record& record) {
    scratch.clear();
    Encode(scratch, record);
    return file.Append({scratch});
  }
  Status WriteDefinitions();
  Status WriteChunk(Gathered& chunk);
  Status WriteChunks();
  void CountChunk(const Gathered& chunk, const ChunkIndex& index);
  Status WriteSummary();
  Gathered& ChunkOf(Lane lane) { return lanes[lane == Lane::kSmall ? 0 : 1]; }

  AppendFile file;
  WriterOptions options;
  ChunkCompressor compressor;
  std::vector<Schema> schemas;    // by id - 1
  std::vector<Channel> channels;  // by id
  std::vector<Lane> lane_of;      // by id of the channel
  std::size_t schemas_written = 0, channels_written = 0;
  std::array<Gathered, 2> lanes;
  bool refused = false;  // by the disk; chunks gather until a flush succeeds
  std::vector<ChunkIndex> chunks;
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  Statistics statistics;
  Bytes scratch;
  bool closed = false;
};

Status McapWriter::Impl::WriteDefinitions() {
  for (; schemas_written < schemas.size(); ++schemas_written) {
    INTAGLIO_TRY(Append(schemas[schemas_written]));
    ++statistics.schema_count;
  }
  for (; channels_written < channels.size(); ++channels_written) {
    INTAGLIO_TRY(Append(channels[channels_written]));
    ++statistics.channel_count;
  }
  return {};
}

Status McapWriter::Impl::WriteChunks() {
  for (Gathered& chunk : lanes) {
    auto written = WriteChunk(chunk);
    refused = !written.has_value();
    if (refused) return written;
  }
  return {};
}

// The whole group of records in one write: a reader that comes in between sees all of it
// or a torn end.
Status McapWriter::Impl::WriteChunk(Gathered& chunk) {
  if (chunk.records.empty()) return {};
  INTAGLIO_TRY(WriteDefinitions());
  ChunkHead& head = chunk.head;
  ByteView packed = chunk.records;
  head.compression.clear();
  if (options.compress) {
    packed = compressor.Compress(chunk.records);
    head.compression = kZstd;
  }
  head.uncompressed_size = chunk.records.size();
  head.uncompressed_crc = io::Crc32(chunk.records);
  head.compressed_size = packed.size();
  Bytes front;
  EncodeChunkHead(front, head);
  ChunkIndex index{head.start_ns,
                   head.end_ns,
                   file.size(),
                   front.size() + packed.size(),
                   {},
                   0,
                   head.compression,
                   head.compressed_size,
                   head.uncompressed_size};
  scratch.clear();
  for (const auto& [channel, entries] : chunk.indexes) {
    index.message_index_offsets[channel] = index.offset + index.length + scratch.size();
    Encode(scratch, entries);
  }
  index.message_index_length = scratch.size();
  INTAGLIO_TRY(file.Append({front, packed, scratch}));
  CountChunk(chunk, index);
  chunk.Clear();
  return {};
}

void McapWriter::Impl::CountChunk(const Gathered& chunk, const ChunkIndex& index) {
  if (statistics.message_count == 0) statistics.start_ns = index.start_ns;
  statistics.start_ns = std::min(statistics.start_ns, index.start_ns);
  statistics.end_ns = std::max(statistics.end_ns, index.end_ns);
  for (const auto& [channel, entries] : chunk.indexes) {
    statistics.message_count += entries.entries.size();
    statistics.message_counts[channel] += entries.entries.size();
  }
  ++statistics.chunk_count;
  chunks.push_back(index);
}

// The specification wants equal opcodes of the summary beside each other.
Status McapWriter::Impl::WriteSummary() {
  Bytes data_end;
  EncodeDataEnd(data_end, file.crc());
  Footer footer;
  footer.summary_start = file.size() + data_end.size();
  Bytes summary, offsets;
  const auto group = [&](Opcode opcode, const auto& encode) {
    const std::size_t begin = summary.size();
    encode();
    if (summary.size() == begin) return;
    EncodeSummaryOffset(offsets, opcode, footer.summary_start + begin,
                        summary.size() - begin);
  };
  const auto all = [&](const auto& list) {
    for (const auto& record : list) Encode(summary, record);
  };
  group(Opcode::kSchema, [&] { all(schemas); });
  group(Opcode::kChannel, [&] { all(channels); });
  group(Opcode::kStatistics, [&] { Encode(summary, statistics); });
  group(Opcode::kChunkIndex, [&] { all(chunks); });
  group(Opcode::kAttachmentIndex, [&] { all(attachments); });
  group(Opcode::kMetadataIndex, [&] { all(metadata); });
  footer.summary_offset_start = footer.summary_start + summary.size();
  PutRaw(summary, offsets);
  const std::size_t before_footer = summary.size();
  Encode(summary, footer);
  const std::size_t crc_at = summary.size() - sizeof footer.summary_crc;
  footer.summary_crc = io::Crc32(ByteView(summary).first(crc_at));
  summary.resize(before_footer);
  Encode(summary, footer);
  PutRaw(summary, std::as_bytes(std::span(kMagic, kMagicSize)));
  return file.Append({data_end, summary});
}

McapWriter::McapWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
McapWriter::McapWriter(McapWriter&&) noexcept = default;
McapWriter& McapWriter::operator=(McapWriter&&) noexcept = default;
McapWriter::~McapWriter() = default;

Result<McapWriter> McapWriter::Create(const std::filesystem::path& file,
                                      const WriterOptions& options) {
  using Existing = AppendFile::Existing;
  auto target = INTAGLIO_TRY(AppendFile::Create(
      file, options.keep_existing ? Existing::kKeep : Existing::kReplace));
  auto impl = std::make_unique<Impl>(std::move(target), options);
  Bytes begin;
  PutRaw(begin, std::as_bytes(std::span(kMagic, kMagicSize)));
  Encode(begin, Header{"", options.library});
  if (auto written = impl->file.Append({begin}); !written) {
    std::error_code ignored;
    if (options.keep_existing) std::filesystem::remove(file, ignored);
    return tl::unexpected(written.error());
  }
  return McapWriter(std::move(impl));
}

std::uint16_t McapWriter::AddSchema(const std::string& name, const std::string& encoding,
                                    const std::string& text) {
  auto& schemas = impl_->schemas;
  for (const Schema& known : schemas) {
    if (known.name == name && known.encoding == encoding && known.text == text)
      return known.id;
  }
  Require(schemas.size() < 65535, "a recording holds 65535 schemas at most");
  const auto id = static_cast<std::uint16_t>(schemas.size() + 1);
  schemas.push_back({id, name, encoding, text});
  return id;
}

std::uint16_t McapWriter::AddChannel(Channel channel, Lane lane) {
  auto& channels = impl_->channels;
  for (const Channel& known : channels) {
    channel.id = known.id;
    if (known == channel) return known.id;
  }
  Require(channels.size() < 65535, "a recording holds 65535 channels at most");
  Require(channel.schema_id <= impl_->schemas.size(), "channel {} of schema {}, of {}",
          channel.topic, channel.schema_id, impl_->schemas.size());
  channel.id = static_cast<std::uint16_t>(channels.size());
  channels.push_back(std::move(channel));
  impl_->lane_of.push_back(lane);
  return channels.back().id;
}

Status McapWriter::Write(const MessageView& message) {
  Impl& impl = *impl_;
  Require(!impl.closed && message.channel_id < impl.channels.size(),
          "a message of channel {}, of {}", message.channel_id, impl.channels.size());
  Gathered& chunk = impl.ChunkOf(impl.lane_of[message.channel_id]);
  chunk.Add(message);
  if (impl.refused) return {};
  const bool old = message.log_time_ns >= chunk.head.start_ns + impl.options.chunk_ns;
  if (!old && chunk.records.size() < impl.options.chunk_bytes) return {};
  auto written = impl.WriteChunk(chunk);
  impl.refused = !written.has_value();
  return written;
}

Status McapWriter::Write(const Metadata& record) {
  Require(!impl_->closed, "metadata after the end");
  MetadataIndex index{impl_->file.size(), 0, record.name};
  INTAGLIO_TRY(impl_->Append(record));
  index.length = impl_->file.size() - index.offset;
  impl_->metadata.push_back(std::move(index));
  ++impl_->statistics.metadata_count;
  return {};
}

Status McapWriter::Write(const Attachment& record) {
  Require(!impl_->closed, "an attachment after the end");
  AttachmentIndex index{
      impl_->file.size(),    0,           record.log_time_ns, record.create_time_ns,
      record.content.size(), record.name, record.media_type};
  INTAGLIO_TRY(impl_->Append(record));
  index.length = impl_->file.size() - index.offset;
  impl_->attachments.push_back(std::move(index));
  ++impl_->statistics.attachment_count;
  return {};
}

Status McapWriter::FlushIfOld(std::uint64_t now_ns) {
  const auto& lanes = impl_->lanes;
  const bool old = std::any_of(lanes.begin(), lanes.end(), [&](const Gathered& chunk) {
    return !chunk.records.empty() &&
           now_ns >= chunk.head.start_ns + impl_->options.chunk_ns;
  });
  return old ? impl_->WriteChunks() : Status();
}

Status McapWriter::Flush() { return impl_->WriteChunks(); }

std::map<std::uint16_t, McapWriter::Dropped> McapWriter::Drop(Lane lane) {
  Gathered& chunk = impl_->ChunkOf(lane);
  std::map<std::uint16_t, Dropped> dropped;
  for (const auto& [channel, index] : chunk.indexes) {
    const auto [first, last] = std::minmax_element(
        index.entries.begin(), index.entries.end(),
        [](const auto& a, const auto& b) { return a.log_time_ns < b.log_time_ns; });
    dropped[channel] = {index.entries.size(), first->log_time_ns, last->log_time_ns};
  }
  chunk.Clear();
  return dropped;
}

Status McapWriter::Close() {
  Require(!impl_->closed, "a recording is closed once");
  INTAGLIO_TRY(impl_->WriteChunks());
  INTAGLIO_TRY(impl_->WriteDefinitions());
  INTAGLIO_TRY(impl_->WriteSummary());
  impl_->closed = true;
  return {};
}

Status McapWriter::Sync() { return impl_->file.Sync(); }

std::uint64_t McapWriter::file_bytes() const { return impl_->file.size(); }
std::uint64_t McapWriter::synced_bytes() const { return impl_->file.synced_size(); }
std::uint64_t McapWriter::gathered_bytes(Lane lane) const {
  return impl_->ChunkOf(lane).records.size();
}
const Statistics& McapWriter::statistics() const { return impl_->statistics; }
const std::filesystem::path& McapWriter::file() const { return impl_->file.path(); }

}  // namespace intaglio::recording
