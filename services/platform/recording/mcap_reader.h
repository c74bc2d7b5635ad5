#pragma once

// Reads a recording, whole or cut anywhere.
//
// A complete file is opened by its summary. One without (its writer was killed, the copy
// was cut) is walked through once, and everything up to its last whole chunk or record is
// there, without repair. A chunk that is damaged in mid-file costs its own messages only.
//
//   auto reader = McapReader::Open("session.mcap");
//   MessageCursor cursor(*reader, {.from_ns = a, .to_ns = b});     // message_cursor.h
//   while (auto message = cursor.Next()) ...
//
// Everything is const after Open and may be used from several threads. Errors name the
// file, the byte and the remedy.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/recording/byte_source.h"
#include "services/platform/recording/mcap_records.h"

namespace intaglio::recording {

struct ReaderLimits {
  /// A chunk, packed or not, and an attachment. 256 MiB: a recorder's chunk holds 1 MB
  /// and the one message that went over it.
  std::uint64_t max_record_bytes = 256u << 20;
};

/// Messages that lie together in the file: a chunk, or a run of bare Message records
/// (other writers' files), whose compression is "-".
struct MessageBlock {
  std::uint64_t start_ns = 0, end_ns = 0;  ///< log time
  std::uint64_t offset = 0, length = 0;    ///< in the file
  std::vector<std::uint16_t> channels;     ///< in it; empty: not known
  std::string compression;                 ///< "zstd", "" or "-"
  std::uint64_t compressed_size = 0, uncompressed_size = 0;
};

struct RecordingContents {
  Header header;
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<MessageBlock> blocks;  ///< in the order of the file
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  Statistics statistics;
  std::uint64_t file_bytes = 0;
  /// Closed: ends with its summary, or with the mark that it has none.
  bool complete = false;
  std::uint64_t torn_bytes = 0;      ///< after the last whole record
  std::vector<std::string> damages;  ///< a sentence each; what they name is left out
};

class McapReader {
 public:
  /// kNotFound, kIo, or kUnreadable when it does not begin as an MCAP file.
  static Result<McapReader> Open(const std::filesystem::path& file,
                                 const ReaderLimits& limits = {});
  static Result<McapReader> Open(std::unique_ptr<ByteSource> source,
                                 const ReaderLimits& limits = {});

  const RecordingContents& contents() const { return contents_; }
  const std::string& name() const { return source_->name(); }

  /// Null when the channel has no schema.
  const Schema* SchemaOf(const Channel& channel) const;
  /// The Message records of a block, one behind the other.
  Result<Bytes> ReadBlock(const MessageBlock& block) const;
  Result<Attachment> Read(const AttachmentIndex& index) const;
  Result<Metadata> Read(const MetadataIndex& index) const;
  /// All metadata records of that name, in the order of the file.
  Result<std::vector<Metadata>> ReadMetadata(const std::string& metadata_name) const;

 private:
  McapReader(std::unique_ptr<ByteSource> source, const ReaderLimits& limits);
  std::unique_ptr<ByteSource> source_;
  ReaderLimits limits_;
  RecordingContents contents_;
};

}  // namespace intaglio::recording
