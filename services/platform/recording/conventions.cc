#include "services/platform/recording/conventions.h"

namespace intaglio::recording {
namespace {

constexpr char kQosPrefix[] = "qos.";

}  // namespace

const char* NameOf(SampleKind kind) {
  switch (kind) {
    case SampleKind::kDisposed:
      return "disposed";
    case SampleKind::kNoWriter:
      return "no_writer";
    default:
      return "value";
  }
}

Channel ChannelOf(const Stream& stream) {
  Channel channel;
  channel.topic = stream.topic;
  if (stream.kind != SampleKind::kValue) {
    channel.topic += std::string("/") + NameOf(stream.kind);
  }
  channel.message_encoding = kCdr;
  channel.metadata = {{"topic", stream.topic},
                      {"type", stream.type},
                      {"domain", stream.bulk ? "bulk" : "control"},
                      {"sample", NameOf(stream.kind)},
                      {"keyed", stream.keyed ? "true" : "false"}};
  if (stream.repeated) channel.metadata["repeated"] = "true";
  if (!stream.partition.empty()) channel.metadata["partition"] = stream.partition;
  for (const auto& [policy, value] : stream.qos) {
    channel.metadata[kQosPrefix + policy] = value;
  }
  return channel;
}

std::optional<Stream> StreamOf(const Channel& channel) {
  const auto entry = [&](const char* name) {
    const auto found = channel.metadata.find(name);
    return found == channel.metadata.end() ? std::string() : found->second;
  };
  Stream stream;
  stream.topic = entry("topic");
  stream.type = entry("type");
  stream.bulk = entry("domain") == "bulk";
  stream.partition = entry("partition");
  stream.keyed = entry("keyed") == "true";
  stream.repeated = entry("repeated") == "true";
  for (const SampleKind kind : {SampleKind::kDisposed, SampleKind::kNoWriter}) {
    if (entry("sample") == NameOf(kind)) stream.kind = kind;
  }
  for (const auto& [name, value] : channel.metadata) {
    if (name.starts_with(kQosPrefix)) stream.qos[name.substr(4)] = value;
  }
  if (stream.topic.empty() || stream.type.empty()) return std::nullopt;
  return stream;
}

bool IsRepeated(const Channel& channel) {
  const auto stream = StreamOf(channel);
  return stream && stream->repeated;
}

}  // namespace intaglio::recording
