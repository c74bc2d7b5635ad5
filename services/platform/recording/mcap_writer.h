#pragma once

// Writes a recording: an MCAP file that is readable up to its last whole chunk at any
// time, also when its writer is killed, and complete once it is closed.
//
// Messages gather in a chunk that is written when it is full (1 MB) or old (1 s): that
// much and no more is lost with the process. Schemas and channels go before the chunk
// that needs them first, not into it: a damaged chunk does not take them along.
//
// Messages of two lanes gather in chunks of their own, so that small things are read
// without unpacking large ones, and large ones may be given up without the small ones.
//
// When the disk refuses a chunk, the file ends with the last whole record and the chunk
// is kept; messages go on gathering in memory, and the next Flush tries again. Drop gives
// a lane's chunk up.
//
// From one thread. Times are given, never taken: no clock in here.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "engrave/core/result.h"
#include "services/platform/recording/mcap_records.h"

namespace intaglio::recording {

struct WriterOptions {
  std::string library;                     ///< e.g. "intaglio 0.1.0"
  std::uint64_t chunk_bytes = 1'000'000;   ///< a chunk is written when it holds this
  std::uint64_t chunk_ns = 1'000'000'000;  ///< or when its first message came so long ago
  bool compress = true;                    ///< zstd; otherwise chunks are stored as is
  int compression_level = 1;               ///< of zstd, -7..19
  bool keep_existing = false;              ///< kRefused when the file is there
};

enum class Lane { kSmall, kLarge };

class McapWriter {
 public:
  /// Messages that were given up.
  struct Dropped {
    std::uint64_t count = 0;
    std::uint64_t from_ns = 0, to_ns = 0;  ///< log time
  };

  /// Makes the file. kIo with path and remedy. With keep_existing nothing is left of one
  /// that could not be begun.
  static Result<McapWriter> Create(const std::filesystem::path& file,
                                   const WriterOptions& options);
  McapWriter(McapWriter&&) noexcept;
  McapWriter& operator=(McapWriter&&) noexcept;
  /// Leaves the file as it is: readable, not complete.
  ~McapWriter();

  /// The id of the schema in this file; an equal one that was added before has the same.
  std::uint16_t AddSchema(const std::string& name, const std::string& encoding,
                          const std::string& text);
  /// The id of the channel in this file; `channel.id` is ignored, and an equal one is not
  /// made twice. At most 65 535 channels.
  std::uint16_t AddChannel(Channel channel, Lane lane = Lane::kSmall);

  /// Takes the message in any case. May write the lane's chunk: an error names what the
  /// disk refused.
  Status Write(const MessageView& message);
  /// An error: not written.
  Status Write(const Metadata& metadata);
  Status Write(const Attachment& attachment);
  /// Writes the chunks whose first message is chunk_ns old.
  Status FlushIfOld(std::uint64_t now_ns);
  /// Writes the chunks.
  Status Flush();
  /// Gives up what has gathered in a lane: how many messages of each channel.
  std::map<std::uint16_t, Dropped> Drop(Lane lane);
  /// Writes the rest and the summary; nothing may be written afterwards.
  Status Close();
  /// Until what was written is on the disk.
  Status Sync();

  std::uint64_t file_bytes() const;    ///< written so far
  std::uint64_t synced_bytes() const;  ///< of them on the disk for certain
  /// Gathered and not yet written, not compressed.
  std::uint64_t gathered_bytes(Lane lane) const;
  const Statistics& statistics() const;
  const std::filesystem::path& file() const;

 private:
  struct Impl;
  explicit McapWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace intaglio::recording
