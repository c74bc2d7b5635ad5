#pragma once

// The files of one recorder: received samples go in, files come out that follow one
// another by size or time, and the oldest go when there are too many. Knows no threads
// and no clock; from one thread.
//
// Every file is complete by itself: it has the types and the newest attachments of the
// files before it, and begins with what was retained by then (conventions.h, "repeated"),
// as far as that fits. A file that cannot be made is tried again each second; until then
// the one before grows.
//
// Repeats count neither as messages nor, when the disk refuses them, as missing.
//
// Messages that are missing in the files are recorded in them, as "missing" records:
// those that the caller could not even queue, bulk that was given up when the disk
// refused, and topics that cannot be recorded. Control waits in memory until the disk
// takes it again, up to 64 MB.
//
// Written data are synced to the disk five times a second, from the thread that writes:
// after a power failure the recording is whole but for its last second (half a second in
// a chunk, a tenth for a turn, a fifth here).

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/recording/bulk.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/mcap_writer.h"
#include "services/platform/recording/retained_state.h"

namespace intaglio::recorder {

struct SeriesOptions {
  /// The first file. Those that follow, and all when it is there already, are
  /// NAME-0002.mcap and so on: none is ever overwritten.
  std::filesystem::path file;
  std::uint64_t split_bytes = 0;  ///< begin a new file at this size; 0: never
  std::uint64_t split_ns = 0;     ///< or after this time; 0: never
  std::uint64_t keep_bytes = 0;   ///< of all files of the series; 0: all
  std::uint64_t keep_ns = 0;      ///< since a file was last written; 0: for ever
  /// Memory for what is retained, to be repeated in the next file; half of split_bytes
  /// at most, so that a file has room for what is new.
  std::uint64_t retained_bytes = 64u << 20;
  /// The same for attachments, the newest; a quarter of split_bytes at most.
  std::uint64_t attachments_bytes = 32u << 20;
  std::string version;  ///< software version
  std::string host;
  recording::BulkRequest bulk;  ///< what the caller does not give; for the metadata
  recording::WriterOptions writer;
};

/// What is known of a stream when its first message comes.
struct StreamTypes {
  std::string idl;      ///< empty: not known
  std::string key_idl;  ///< empty: no key
  std::map<std::string, std::string> recipe;
};

class RecordingSeries {
 public:
  /// Makes the first file. kIo with path and remedy.
  static Result<RecordingSeries> Open(const SeriesOptions& options, std::uint64_t now_ns);

  /// The number of the stream in this series; an equal one has the same.
  std::uint32_t AddStream(const recording::Stream& stream, const StreamTypes& types);

  void Write(std::uint32_t stream, std::uint64_t log_time_ns,
             std::uint64_t publish_time_ns, recording::ByteView payload);
  /// A message that follows from others, e.g. a picture of them: it does not count, and
  /// is left out while the disk refuses. Its schema is of the encoding of its channel.
  struct Derived {
    std::string topic, type, encoding, schema;
  };
  void Write(const Derived& of, std::uint64_t log_time_ns, recording::ByteView payload);
  /// A message of the stream that could not be queued.
  void CountMissing(std::uint32_t stream, std::uint64_t log_time_ns,
                    const std::string& reason, std::uint64_t count = 1);
  /// A topic that is not recorded.
  void ReportUnrecorded(const std::string& topic, const std::string& reason);
  /// Goes into this file and those that follow, until newer ones take its place.
  void Attach(recording::Attachment attachment);

  /// To be called some times a second: writes what is old, tries the disk again, begins
  /// the next file, removes the oldest.
  void Turn(std::uint64_t now_ns);
  /// Writes the rest and completes the file.
  Status Close();

  /// What the disk refuses at the moment.
  const std::optional<Error>& trouble() const {
    return trouble_ ? trouble_ : no_next_file_;
  }
  const std::filesystem::path& file() const { return writer_->file(); }
  std::uint32_t file_number() const { return file_number_; }
  /// Bytes of this file that are on the disk for certain.
  std::uint64_t synced_bytes() const { return writer_->synced_bytes(); }
  std::uint64_t message_count() const { return message_count_; }
  std::uint64_t missing_count() const { return missing_count_; }

 private:
  struct Known {
    recording::Stream stream;
    StreamTypes types;
    std::optional<std::uint16_t> channel;   // in the file that is open
    std::optional<std::uint16_t> repeated;  // so, too
    std::uint32_t sequence = 0;
  };
  struct Missing {
    std::uint64_t count = 0;
    std::uint64_t from_ns = 0, to_ns = 0;
  };
  RecordingSeries(const SeriesOptions& options, std::uint64_t now_ns);
  Status OpenNext(std::uint64_t now_ns);
  std::uint16_t Define(const Known& known, bool repeated);
  void Repeat(std::uint64_t log_time_ns);
  void ReportForgotten();
  void Note(const Status& written);
  void GiveUp(recording::Lane lane, const char* reason);
  void WriteMissing(std::uint64_t now_ns);
  void BeginNext(std::uint64_t now_ns);
  void SyncIfDue(std::uint64_t now_ns);
  void ForgetOldAttachments();
  void WritePending();
  void RemoveOldest() const;

  SeriesOptions options_;
  std::optional<recording::McapWriter> writer_;
  std::uint64_t file_began_ns_;
  std::uint64_t synced_ns_ = 0;
  std::uint32_t file_number_ = 0;
  std::map<std::string, std::uint32_t> derived_count_;  // by topic, in this file
  std::vector<Known> streams_;
  std::map<std::uint16_t, std::uint32_t> stream_of_channel_;
  recording::RetainedState retained_;
  std::uint64_t retained_limit_bytes_ = 0;  // 0: no file will follow
  bool repeated_ = true;                    // what was retained, in this file
  std::deque<recording::Attachment> attachments_;
  std::uint64_t attachments_limit_bytes_ = 0;
  std::vector<recording::Metadata> unrecorded_;
  std::size_t attachments_written_ = 0, unrecorded_written_ = 0;      // in this file
  std::vector<std::string> types_written_;                            // in this file
  std::map<std::pair<std::uint32_t, std::string>, Missing> missing_;  // by reason
  std::optional<Error> trouble_;
  std::optional<Error> no_next_file_;
  std::optional<std::uint64_t> split_refused_ns_, removed_ns_;
  std::uint64_t message_count_ = 0, missing_count_ = 0;
};

}  // namespace intaglio::recorder
