#include "services/replayer/recorded_samples.h"

#include <fmt/format.h>

#include <set>

#include "engrave/core/try.h"
#include "services/platform/recording/conventions.h"
#include "services/replayer/recorded_members.h"

namespace intaglio::replayer {
namespace {

using recording::Value;

std::set<std::uint16_t> ValueChannelsOf(const recording::McapReader& reader,
                                        const std::string& topic) {
  std::set<std::uint16_t> channels;
  for (const auto& [id, channel] : reader.contents().channels) {
    const auto stream = recording::StreamOf(channel);
    // A repeated task is one whose inputs and outputs lie in an earlier file.
    if (stream && stream->topic == topic && !stream->repeated &&
        stream->kind == recording::SampleKind::kValue)
      channels.insert(id);
  }
  return channels;
}

}  // namespace

std::optional<RecordedTask> ReadTask(const Value& value) {
  RecordedTask task;
  Members members(value);
  members.Get(task.id);
  members.Get("epoch", task.epoch);
  members.Get("part_count", task.part_count);
  members.Get("input_part_count", task.input_part_count);
  members.Get("revoked", task.revoked);
  if (const Value* member = value.Find("take_up")) {  // younger than the others
    if (const bool* held = member->As<bool>()) task.take_up = *held;
  }
  std::vector<std::uint8_t> job;
  members.Get("frozen_job", job);
  task.frozen_job.assign(job.begin(), job.end());
  return members.good() ? std::optional(std::move(task)) : std::nullopt;
}

std::optional<CloudBatch> ReadBatch(const Value& value) {
  CloudBatch batch;
  Members members(value);
  members.Get(batch.id);
  members.Get("part_count", batch.part_count);
  members.Get("sequence_number", batch.sequence_number);
  members.Get("first_index", batch.first_index);
  members.Get("total_count", batch.total_count);
  members.Get("last", batch.last);
  members.Get("x_mm", batch.x_mm);
  members.Get("y_mm", batch.y_mm);
  members.Get("z_mm", batch.z_mm);
  members.Get("source", batch.source);
  const std::size_t size = batch.x_mm.size();
  const bool even = batch.y_mm.size() == size && batch.z_mm.size() == size &&
                    batch.source.size() == size;
  return members.good() && even ? std::optional(std::move(batch)) : std::nullopt;
}

std::optional<ModelPiece> ReadPiece(const Value& value) {
  ModelPiece piece;
  Members members(value);
  members.Get(piece.id);
  members.Get("sequence_number", piece.sequence_number);
  members.Get("model", piece.model);
  members.Get("offset", piece.offset);
  members.Get("file_size", piece.file_size);
  members.Get("last", piece.last);
  members.Get("bytes", piece.bytes);
  return members.good() ? std::optional(std::move(piece)) : std::nullopt;
}

RecordedValues::RecordedValues(const recording::McapReader& reader,
                               const std::string& topic, std::uint64_t from_ns)
    : decoder_(reader),
      cursor_(reader, {.from_ns = from_ns, .channels = ValueChannelsOf(reader, topic)}) {}

Result<std::optional<Value>> RecordedValues::Next() {
  const auto message = INTAGLIO_TRY(cursor_.Next());
  if (!message) return std::nullopt;
  log_time_ns_ = message->log_time_ns;
  publish_time_ns_ = message->publish_time_ns;
  auto value = INTAGLIO_TRY(decoder_.Decode(*message));
  return std::optional(std::move(value));
}

Result<std::map<StreamId, StreamExtent>> ExtentsOf(const recording::McapReader& reader,
                                                   const std::string& topic) {
  std::map<StreamId, StreamExtent> extents;
  RecordedValues values(reader, topic);
  for (;;) {
    const auto value = INTAGLIO_TRY(values.Next());
    if (!value) return extents;
    StreamId id;
    std::uint64_t number = 0;
    bool last = false;
    Members members(*value);
    members.Get(id);
    members.Get("sequence_number", number);
    members.Get("last", last);
    if (!members.good()) {
      return Fail(ErrorCode::kUnsupported,
                  topic + ": the recording has a version whose samples are unknown",
                  topic);
    }
    StreamExtent& extent = extents[id];
    if (number != extent.count) continue;
    ++extent.count;
    extent.whole = last;
  }
}

}  // namespace intaglio::replayer
