#include "services/scene/scene_file.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <span>
#include <utility>

#include "engrave/core/try.h"
#include "services/platform/recording/bulk.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/message_decoder.h"
#include "services/platform/recording/whole_recording.h"
#include "services/scene/message_schema.h"
#include "services/scene/scene_maker.h"

namespace intaglio::scene {
namespace {

using recording::McapReader;
using recording::McapWriter;

/// Writes each message into the channel of its topic.
class Channels {
 public:
  explicit Channels(McapWriter& writer) : writer_(writer) {}

  Status Write(const std::string& topic, const google::protobuf::Message& message,
               std::uint64_t time_ns) {
    Used& used = used_[topic];
    if (used.count == 0) used.id = Add(topic, *message.GetDescriptor());
    const std::string bytes = message.SerializeAsString();
    recording::MessageView view;
    view.channel_id = used.id;
    view.sequence = used.count++;
    view.log_time_ns = view.publish_time_ns = time_ns;
    view.payload = std::as_bytes(std::span(bytes));
    return writer_.Write(view);
  }

 private:
  struct Used {
    std::uint16_t id = 0;
    std::uint32_t count = 0;
  };
  std::uint16_t Add(const std::string& topic, const google::protobuf::Descriptor& type) {
    recording::Channel channel;
    channel.schema_id = writer_.AddSchema(type.full_name(), kProtobuf, SchemaOf(type));
    channel.topic = TopicInFile(topic);
    channel.message_encoding = kProtobuf;
    return writer_.AddChannel(std::move(channel));
  }
  McapWriter& writer_;
  std::map<std::string, Used> used_;  // by topic
};

void AddJobs(const McapReader& reader, SceneMaker& maker) {
  for (const recording::AttachmentIndex& index : reader.contents().attachments) {
    const auto attachment = reader.Read(index);
    if (!attachment) continue;  // `recording info` names it
    if (const auto job = JobOf(*attachment)) maker.AddJob(*job);
  }
}

std::string CellOf(const recording::Channel& channel) {
  const auto stream = recording::StreamOf(channel);
  return stream ? stream->partition : std::string();
}

std::set<std::uint16_t> DrawnChannels(const McapReader& reader) {
  std::set<std::uint16_t> drawn;
  for (const auto& [id, channel] : reader.contents().channels) {
    if (SceneMaker::Draws(channel.topic) && !recording::IsRepeated(channel))
      drawn.insert(id);
  }
  return drawn;
}

Status Draw(const McapReader& reader, recording::MessageQuery query, SceneMaker& maker) {
  AddJobs(reader, maker);
  query.channels = DrawnChannels(reader);
  recording::MessageDecoder decoder(reader);
  recording::MessageCursor cursor(reader, query);
  for (;;) {
    const auto message = INTAGLIO_TRY(cursor.Next());
    if (!message) return maker.Finish();
    const auto value = INTAGLIO_TRY(decoder.Decode(*message));
    const recording::Channel& channel =
        reader.contents().channels.at(message->channel_id);
    INTAGLIO_TRY(maker.Add(channel.topic, CellOf(channel), value, message->log_time_ns));
  }
}

Error NoPoints(const McapReader& reader) {
  const std::string left_out = SentenceOf(recording::BulkRequestOf(reader));
  return {ErrorCode::kMissing,
          fmt::format("{}: no points of a job are in it{}; a scene is made of a job of "
                      "points that was recorded from its path on",
                      reader.name(), left_out.empty() ? "" : ", for " + left_out),
          reader.name()};
}

}  // namespace

Status WriteScene(const McapReader& reader, const recording::MessageQuery& query,
                  const std::filesystem::path& target) {
  const auto fill = [&](McapWriter& writer) -> Status {
    Channels channels(writer);
    SceneMaker maker(
        [&](const std::string& topic, const auto& message, std::uint64_t time_ns) {
          return channels.Write(topic, message, time_ns);
        });
    INTAGLIO_TRY(Draw(reader, query, maker));
    if (maker.drawn_count() == 0) return tl::unexpected(NoPoints(reader));
    return {};
  };
  return recording::WriteWhole({reader.name()}, target, reader.contents().header.library,
                               fill);
}

}  // namespace intaglio::scene
