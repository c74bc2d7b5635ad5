#pragma once

// The records of MCAP, the container of recordings (https://mcap.dev/spec, version 0).
//
//   file:     magic, Header, data, DataEnd, summary, summary offsets, Footer, magic
//   magic:    89 4D 43 41 50 30 0D 0A
//   record:   opcode (1 byte), length of the content (8), content
//
//   data:     Schema and Channel before the first message of theirs; Chunk, followed by a
//             MessageIndex a channel in it; Attachment; Metadata
//   chunk:    start and end (log time of its messages), size and CRC-32 of what is in it,
//             compression ("zstd" or ""), and the records themselves
//   summary:  Schema, Channel, Statistics, ChunkIndex, AttachmentIndex, MetadataIndex
//
// Numbers are little endian. Times are ns since 1970-01-01 UTC. A text is its length (4)
// and its UTF-8 bytes. A CRC-32 is that of zlib; 0 says that none was computed. A record
// of an opcode that is not known, and bytes behind the known fields of a record, are
// skipped: the specification requires this, for files of later writers.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "services/platform/recording/mcap_fields.h"

namespace intaglio::recording {

inline constexpr std::size_t kMagicSize = 8;
extern const char kMagic[kMagicSize + 1];
inline constexpr std::size_t kRecordHeadSize = 9;

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0a,
  kStatistics = 0x0b,
  kMetadata = 0x0c,
  kMetadataIndex = 0x0d,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

struct Header {
  std::string profile;  ///< conventions that the file follows; ours: none
  std::string library;  ///< who wrote it
};

struct Footer {
  std::uint64_t summary_start = 0;         ///< offset in the file; 0: no summary
  std::uint64_t summary_offset_start = 0;  ///< offset in the file; 0: none
  std::uint32_t summary_crc = 0;  ///< from summary_start to the field before this
};

/// A type of messages.
struct Schema {
  std::uint16_t id = 0;  ///< from 1
  std::string name;      ///< e.g. "intaglio::JobStatus"
  std::string encoding;  ///< ours: "omgidl", the type's IDL text
  std::string text;
  bool operator==(const Schema&) const = default;
};

/// A stream of messages of one topic.
struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;
  std::string topic;
  std::string message_encoding;  ///< ours: "cdr", with the 4 bytes of encapsulation
  TextMap metadata;
  bool operator==(const Channel&) const = default;
};

/// A message in storage that it does not own.
struct MessageView {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;         ///< counts the messages of the channel
  std::uint64_t log_time_ns = 0;      ///< when it was received
  std::uint64_t publish_time_ns = 0;  ///< when it was sent, by the sender's clock
  ByteView payload;
};

/// Head of a Chunk, without its records.
struct ChunkHead {
  std::uint64_t start_ns = 0, end_ns = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;
  std::string compression;
  std::uint64_t compressed_size = 0;
};

struct ChunkIndex {
  std::uint64_t start_ns = 0, end_ns = 0;
  std::uint64_t offset = 0;  ///< of the Chunk record in the file
  std::uint64_t length = 0;  ///< of the Chunk record with its opcode and length
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;  ///< by channel
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0, uncompressed_size = 0;
};

struct MessageIndex {
  struct Entry {
    std::uint64_t log_time_ns = 0;
    std::uint64_t offset = 0;  ///< of the Message record in the uncompressed chunk
  };
  std::uint16_t channel_id = 0;
  std::vector<Entry> entries;
};

/// A file inside the file.
struct Attachment {
  std::uint64_t log_time_ns = 0, create_time_ns = 0;
  std::string name;
  std::string media_type;
  Bytes content;
};

struct AttachmentIndex {
  std::uint64_t offset = 0, length = 0;  ///< of the Attachment record in the file
  std::uint64_t log_time_ns = 0, create_time_ns = 0;
  std::uint64_t content_size = 0;
  std::string name;
  std::string media_type;
};

struct Metadata {
  std::string name;
  TextMap entries;
  bool operator==(const Metadata&) const = default;
};

struct MetadataIndex {
  std::uint64_t offset = 0, length = 0;  ///< of the Metadata record in the file
  std::string name;
};

struct Statistics {
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0;
  std::uint32_t attachment_count = 0;
  std::uint32_t metadata_count = 0;
  std::uint32_t chunk_count = 0;
  std::uint64_t start_ns = 0, end_ns = 0;                 ///< log time of the messages
  std::map<std::uint16_t, std::uint64_t> message_counts;  ///< by channel
};

// Appends the record, opcode and length included.
void Encode(Bytes& out, const Header& record);
void Encode(Bytes& out, const Footer& record);
void Encode(Bytes& out, const Schema& record);
void Encode(Bytes& out, const Channel& record);
void Encode(Bytes& out, const MessageView& record);
void Encode(Bytes& out, const MessageIndex& record);
void Encode(Bytes& out, const ChunkIndex& record);
void Encode(Bytes& out, const Attachment& record);  ///< computes its CRC
void Encode(Bytes& out, const AttachmentIndex& record);
void Encode(Bytes& out, const Statistics& record);
void Encode(Bytes& out, const Metadata& record);
void Encode(Bytes& out, const MetadataIndex& record);
/// The Chunk record up to its records, which follow it in the file.
void EncodeChunkHead(Bytes& out, const ChunkHead& head);
void EncodeSummaryOffset(Bytes& out, Opcode group, std::uint64_t start,
                         std::uint64_t length);
void EncodeDataEnd(Bytes& out, std::uint32_t crc);

// Read the content of a record, without opcode and length; false when it is too short or
// has an impossible value. Views point into `content`.
bool Decode(ByteView content, Header& record);
bool Decode(ByteView content, Footer& record);
bool Decode(ByteView content, Schema& record);
bool Decode(ByteView content, Channel& record);
bool Decode(ByteView content, MessageView& record);
bool Decode(ByteView content, MessageIndex& record);
bool Decode(ByteView content, ChunkIndex& record);
bool Decode(ByteView content, Attachment& record);  ///< checks its CRC
bool Decode(ByteView content, AttachmentIndex& record);
bool Decode(ByteView content, Statistics& record);
bool Decode(ByteView content, Metadata& record);
bool Decode(ByteView content, MetadataIndex& record);
/// `content` may end anywhere behind the head; `head_size` is the offset at which the
/// records begin.
bool DecodeChunkHead(ByteView content, ChunkHead& head, std::size_t& head_size);

}  // namespace intaglio::recording
