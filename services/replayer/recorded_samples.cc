#include "services/replayer/recorded_samples.h"

#include <fmt/format.h>

#include <set>
#include <type_traits>

#include "services/recording/conventions.h"

namespace intaglio::replayer {
namespace {

using recording::Value;

/// Reads members by name; good() is false once one was not there or of another kind.
class Members {
 public:
  explicit Members(const Value& value) : value_(value) {}

  template <typename T>
  requires std::is_unsigned_v<T>
  void Get(const char* name, T& out) {
    if constexpr (std::is_same_v<T, bool>) {
      if (const bool* held = As<bool>(name)) out = *held;
    } else if (const auto* held = As<std::uint64_t>(name)) {
      out = static_cast<T>(*held);
    }
  }
  void Get(const char* name, std::string& out) {
    if (const auto* held = As<std::string>(name)) out = *held;
  }
  void Get(const char* name, std::vector<double>& out) {
    if (const auto* held = As<std::vector<double>>(name)) out = *held;
  }
  template <typename T>
  requires std::is_unsigned_v<T>
  void Get(const char* name, std::vector<T>& out) {
    if (const auto* held = As<std::vector<std::uint64_t>>(name)) {
      out.reserve(held->size());
      for (const std::uint64_t number : *held) out.push_back(static_cast<T>(number));
    }
  }
  void Get(StreamId& id) {
    Get("job_uid", id.job_uid);
    Get("attempt", id.attempt);
    Get("part", id.part);
    Get("part_attempt", id.part_attempt);
  }
  bool good() const { return good_; }

 private:
  template <typename T>
  const T* As(const char* name) {
    const Value* member = value_.Find(name);
    const T* held = member == nullptr ? nullptr : member->As<T>();
    good_ = good_ && held != nullptr;
    return held;
  }
  const Value& value_;
  bool good_ = true;
};

std::set<std::uint16_t> ValueChannelsOf(const recording::McapReader& reader,
                                        const std::string& topic) {
  std::set<std::uint16_t> channels;
  for (const auto& [id, channel] : reader.contents().channels) {
    const auto stream = recording::StreamOf(channel);
    if (stream && stream->topic == topic && stream->kind == recording::SampleKind::kValue)
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
    : reader_(reader),
      cursor_(reader, {.from_ns = from_ns, .channels = ValueChannelsOf(reader, topic)}) {}

Result<Value> RecordedValues::Decode(const recording::MessageView& message) {
  const recording::Channel& channel = reader_.contents().channels.at(message.channel_id);
  const recording::Schema* schema = reader_.SchemaOf(channel);
  if (schema == nullptr) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("topic {}: its type is not in the recording", channel.topic),
                channel.topic);
  }
  const auto [types, added] = types_.try_emplace(schema->id);
  if (added) {
    auto parsed = recording::ParseIdl(schema->text);
    if (!parsed) return tl::unexpected(parsed.error());
    types->second = std::move(*parsed);
  }
  return recording::DecodeCdr(types->second, schema->name, message.payload);
}

Result<std::optional<Value>> RecordedValues::Next() {
  const auto message = cursor_.Next();
  if (!message) return tl::unexpected(message.error());
  if (!*message) return std::nullopt;
  log_time_ns_ = (*message)->log_time_ns;
  auto value = Decode(**message);
  if (!value) return tl::unexpected(value.error());
  return std::optional(std::move(*value));
}

Result<std::map<StreamId, StreamExtent>> ExtentsOf(const recording::McapReader& reader,
                                                   const std::string& topic) {
  std::map<StreamId, StreamExtent> extents;
  RecordedValues values(reader, topic);
  for (;;) {
    const auto value = values.Next();
    if (!value) return tl::unexpected(value.error());
    if (!*value) return extents;
    StreamId id;
    std::uint64_t number = 0;
    bool last = false;
    Members members(**value);
    members.Get(id);
    members.Get("sequence_number", number);
    members.Get("last", last);
    if (!members.good()) {
      return Fail(ErrorCode::kUnsupported,
                  topic + ": the recording is of a version whose samples are not known",
                  topic);
    }
    StreamExtent& extent = extents[id];
    if (number != extent.count) continue;
    ++extent.count;
    extent.whole = last;
  }
}

}  // namespace intaglio::replayer
