#include "services/replayer/retained.h"

#include <fmt/format.h>

#include <map>
#include <set>

namespace intaglio::replayer {
namespace {

/// By type, as the recipes in the recording name them.
std::map<std::string, std::string> KeysOf(const recording::McapReader& reader) {
  std::map<std::string, std::string> keys_of;
  const auto recipes = reader.ReadMetadata(recording::kTypeRecord);
  if (!recipes) return keys_of;
  for (const recording::Metadata& recipe : *recipes) {
    const auto name = recipe.entries.find("name"), keys = recipe.entries.find("keys");
    if (name != recipe.entries.end() && keys != recipe.entries.end())
      keys_of[name->second] = keys->second;
  }
  return keys_of;
}

}  // namespace

std::vector<recording::RetainedSample> Retained::Before(std::uint64_t log_time_ns) {
  auto keys_of = KeysOf(reader_);
  recording::RetainedState state;
  std::set<std::uint16_t> channels;
  for (const auto& [id, played] : selection_.channels) {
    const recording::Stream& stream = played.stream;
    if (!recording::IsRetained(stream)) continue;
    const recording::Schema* schema =
        reader_.SchemaOf(reader_.contents().channels.at(id));
    recording::SampleType type;
    if (schema != nullptr) type = {schema->name, schema->text, keys_of[stream.type]};
    if (state.Learn(id, stream, type)) {
      channels.insert(id);
    } else {
      complaints_.push_back(fmt::format(
          "{} is not restored: the recording does not contain its key", stream.topic));
    }
  }
  recording::MessageCursor cursor(reader_, {.to_ns = log_time_ns, .channels = channels});
  for (;;) {
    const auto message = cursor.Next();
    if (!message) {
      complaints_.push_back(message.error().message);
      continue;
    }
    if (!*message) break;
    const recording::MessageView& view = **message;
    state.Receive(view.channel_id, view.sequence, view.log_time_ns, view.publish_time_ns,
                  view.payload);
  }
  std::vector<recording::RetainedSample> samples;
  for (const recording::RetainedSample* sample : state.Samples())
    samples.push_back(*sample);
  return samples;
}

}  // namespace intaglio::replayer
