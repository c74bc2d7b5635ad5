#include "services/replayer/retained.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "services/recording/cdr_value.h"

namespace intaglio::replayer {
namespace {

constexpr char kKeepLast[] = "keep_last ";

std::size_t DepthOf(const recording::Stream& stream) {
  const auto history = stream.qos.find("history");
  std::size_t depth = 1;
  if (history != stream.qos.end() && history->second.starts_with(kKeepLast)) {
    const std::string& text = history->second;
    (void)std::from_chars(text.data() + sizeof kKeepLast - 1, text.data() + text.size(),
                          depth);
  }
  return std::max<std::size_t>(1, depth);
}

bool IsRetained(const recording::Stream& stream) {
  const auto durability = stream.qos.find("durability");
  return durability != stream.qos.end() && durability->second != "volatile";
}

/// The names in a recipe's "name offset index;" list.
std::vector<std::string> NamesOf(std::string_view keys) {
  std::vector<std::string> names;
  while (!keys.empty()) {
    const std::size_t end = std::min(keys.find(';'), keys.size());
    names.emplace_back(keys.substr(0, std::min(keys.find(' '), end)));
    keys.remove_prefix(std::min(end + 1, keys.size()));
  }
  return names;
}

const recording::Value* Find(const recording::Value& value, std::string_view path) {
  const recording::Value* at = &value;
  while (at != nullptr && !path.empty()) {
    const std::size_t end = std::min(path.find('.'), path.size());
    at = at->Find(std::string(path.substr(0, end)));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return at;
}

}  // namespace

Retained::Retained(const recording::McapReader& reader, const Selection& selection)
    : reader_(reader), selection_(selection) {
  if (const auto recipes = reader.ReadMetadata(recording::kTypeRecord)) {
    for (const recording::Metadata& recipe : *recipes) {
      const auto name = recipe.entries.find("name"), keys = recipe.entries.find("keys");
      if (name != recipe.entries.end() && keys != recipe.entries.end())
        key_names_[name->second] = NamesOf(keys->second);
    }
  }
  for (const auto& [id, channel] : selection.channels) {
    if (IsRetained(channel.stream)) Learn(id, channel.stream);
  }
}

void Retained::Learn(std::uint16_t channel_id, const recording::Stream& stream) {
  Keyed& keyed = keyed_[channel_id];
  keyed.depth = DepthOf(stream);
  keyed.readable = !stream.keyed;
  if (!stream.keyed) return;
  keyed.key_names = key_names_[stream.type];
  const recording::Channel& channel = reader_.contents().channels.at(channel_id);
  const recording::Schema* schema = reader_.SchemaOf(channel);
  if (schema == nullptr || keyed.key_names.empty()) return;
  auto types = recording::ParseIdl(schema->text);
  if (!types) return;
  keyed.types = std::move(*types);
  keyed.value_type = schema->name;
  keyed.readable = true;
}

/// The key's members as text; empty when it cannot be read.
std::string Retained::KeyOf(const Keyed& keyed, recording::ByteView payload) {
  const auto value = recording::DecodeCdr(keyed.types, keyed.value_type, payload);
  if (!value) return {};
  std::string key;
  for (const std::string& name : keyed.key_names) {
    const recording::Value* member = Find(*value, name);
    if (member == nullptr) return {};
    key += JsonOf(*member) + "\n";
  }
  return key;
}

void Retained::Take(std::map<Instance, std::deque<RetainedMessage>>& kept,
                    const recording::MessageView& message) {
  const auto found = keyed_.find(message.channel_id);
  if (found == keyed_.end() || !found->second.readable) return;
  const Keyed& keyed = found->second;
  const recording::Stream& stream = selection_.channels.at(message.channel_id).stream;
  std::string key;
  if (stream.keyed && (key = KeyOf(keyed, message.payload)).empty()) return;
  const Instance instance{stream.topic + "\n" + stream.partition, key};
  if (stream.kind != recording::SampleKind::kValue) {
    kept.erase(instance);
    return;
  }
  auto& samples = kept[instance];
  samples.push_back({message.channel_id,
                     message.log_time_ns,
                     message.publish_time_ns,
                     {message.payload.begin(), message.payload.end()}});
  if (samples.size() > keyed.depth) samples.pop_front();
}

std::vector<RetainedMessage> Retained::Before(std::uint64_t log_time_ns) {
  std::set<std::uint16_t> channels;
  for (const auto& [id, keyed] : keyed_) {
    const recording::Stream& stream = selection_.channels.at(id).stream;
    if (keyed.readable) {
      channels.insert(id);
    } else {
      complaints_.push_back(fmt::format(
          "{} is not restored: the recording does not tell its key", stream.topic));
    }
  }
  std::map<Instance, std::deque<RetainedMessage>> kept;
  recording::MessageCursor cursor(reader_, {.to_ns = log_time_ns, .channels = channels});
  for (;;) {
    const auto message = cursor.Next();
    if (!message) {
      complaints_.push_back(message.error().message);
      continue;
    }
    if (!*message) break;
    Take(kept, **message);
  }
  std::vector<RetainedMessage> all;
  for (auto& [instance, samples] : kept) {
    std::move(samples.begin(), samples.end(), std::back_inserter(all));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.log_time_ns < b.log_time_ns;
  });
  return all;
}

}  // namespace intaglio::replayer
