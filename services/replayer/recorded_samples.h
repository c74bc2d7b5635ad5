#pragma once

// Tasks, models and points of a recording, read member by member with the types that it
// holds itself: also those of a version whose types were other ones.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "services/platform/recording/cdr_value.h"
#include "services/platform/recording/message_cursor.h"
#include "services/platform/recording/message_decoder.h"

namespace intaglio::replayer {

/// A stream of points or chunks: a part of a job, and whose turn at it.
struct StreamId {
  std::string job_uid;
  std::uint32_t attempt = 0, part = 0, part_attempt = 0;
  auto operator<=>(const StreamId&) const = default;
};

struct RecordedTask {
  StreamId id;
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;
  std::uint64_t epoch = 0;
  std::uint32_t part_count = 1, input_part_count = 1;
  bool revoked = false, take_up = false;
  std::string frozen_job;  ///< intaglio.FrozenJob, serialized
};

/// A PointBatch or PathBatch.
struct CloudBatch {
  StreamId id;
  std::uint32_t part_count = 1;
  std::uint64_t sequence_number = 0, first_index = 0, total_count = 0;
  bool last = false;
  std::vector<double> x_mm, y_mm, z_mm;
  std::vector<std::uint32_t> source;
};

struct ModelPiece {
  StreamId id;
  std::uint64_t sequence_number = 0;
  std::uint32_t model = 0;
  std::uint64_t offset = 0, file_size = 0;
  bool last = false;
  std::vector<std::uint8_t> bytes;
};

// Nothing for a value that has not all the members.
std::optional<RecordedTask> ReadTask(const recording::Value& value);
std::optional<CloudBatch> ReadBatch(const recording::Value& value);
std::optional<ModelPiece> ReadPiece(const recording::Value& value);

/// The values of one topic in the order of their reception; repeats of an earlier file's
/// (conventions.h) are not among them.
class RecordedValues {
 public:
  RecordedValues(const recording::McapReader& reader, const std::string& topic,
                 std::uint64_t from_ns = 0);
  /// Nothing at the end; an error once for a place that cannot be read.
  Result<std::optional<recording::Value>> Next();
  std::uint64_t log_time_ns() const { return log_time_ns_; }  ///< of the last
  std::uint64_t publish_time_ns() const { return publish_time_ns_; }

 private:
  recording::MessageDecoder decoder_;
  recording::MessageCursor cursor_;
  std::uint64_t log_time_ns_ = 0, publish_time_ns_ = 0;
};

/// How much of a stream there is.
struct StreamExtent {
  std::uint64_t count = 0;  ///< samples from number 0 on, without gaps
  bool whole = false;       ///< up to the last one
};
/// The extents of all streams of a topic of batches or chunks.
Result<std::map<StreamId, StreamExtent>> ExtentsOf(const recording::McapReader& reader,
                                                   const std::string& topic);

}  // namespace intaglio::replayer
