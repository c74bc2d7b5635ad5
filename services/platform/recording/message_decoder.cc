#include "services/platform/recording/message_decoder.h"

#include <fmt/format.h>

#include "services/platform/recording/conventions.h"

namespace intaglio::recording {

Result<Value> MessageDecoder::Decode(const MessageView& message) {
  const Channel& channel = reader_.contents().channels.at(message.channel_id);
  const Schema* schema = reader_.SchemaOf(channel);
  if (schema == nullptr) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("topic {}: its type is not in the recording", channel.topic),
                channel.topic);
  }
  if (schema->encoding != kOmgIdl || channel.message_encoding != kCdr) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("topic {}: only cdr messages with omgidl schemas can be read",
                            channel.topic),
                channel.topic);
  }
  auto types = types_.find(schema->id);
  if (types == types_.end()) {
    types = types_.emplace(schema->id, ParseIdl(schema->text)).first;
  }
  if (!types->second) return tl::unexpected(types->second.error());
  return DecodeCdr(*types->second, schema->name, message.payload);
}

}  // namespace intaglio::recording
