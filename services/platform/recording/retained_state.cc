#include "services/platform/recording/retained_state.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "services/platform/recording/cdr_value.h"

namespace intaglio::recording {
namespace {

constexpr char kKeepLast[] = "keep_last ";
// A sample and an instance take this memory besides their bytes.
constexpr std::uint64_t kSampleOverhead = sizeof(RetainedSample) + 32;
constexpr std::uint64_t kInstanceOverhead = 256;

std::size_t DepthOf(const Stream& stream) {
  const auto history = stream.qos.find("history");
  std::size_t depth = 1;
  if (history != stream.qos.end() && history->second.starts_with(kKeepLast)) {
    const std::string& text = history->second;
    (void)std::from_chars(text.data() + sizeof kKeepLast - 1, text.data() + text.size(),
                          depth);
  }
  return std::max<std::size_t>(1, depth);
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

const Value* Find(const Value& value, std::string_view path) {
  const Value* at = &value;
  while (at != nullptr && !path.empty()) {
    const std::size_t end = std::min(path.find('.'), path.size());
    at = at->Find(std::string(path.substr(0, end)));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return at;
}

}  // namespace

bool IsRetained(const Stream& stream) {
  const auto durability = stream.qos.find("durability");
  return durability != stream.qos.end() && durability->second != "volatile";
}

bool RetainedState::Learn(std::uint32_t number, const Stream& stream,
                          const SampleType& type) {
  Learned learned;
  learned.place =
      stream.topic + "\n" + stream.partition + "\n" + (stream.bulk ? "bulk" : "control");
  learned.kind = stream.kind;
  learned.keyed = stream.keyed;
  learned.depth = DepthOf(stream);
  if (stream.keyed) {
    learned.key_names = NamesOf(type.keys);
    auto types = ParseIdl(type.idl);
    if (type.idl.empty() || learned.key_names.empty() || !types) return false;
    learned.types = std::move(*types);
    learned.value_type = type.name;
  }
  learned_.insert_or_assign(number, std::move(learned));
  return true;
}

/// The key's members as text; empty when it cannot be read.
std::string RetainedState::KeyOf(const Learned& learned, ByteView payload) {
  const auto value = DecodeCdr(learned.types, learned.value_type, payload);
  if (!value) return {};
  std::string key;
  for (const std::string& name : learned.key_names) {
    const Value* member = Find(*value, name);
    if (member == nullptr) return {};
    key += JsonOf(*member) + "\n";
  }
  return key;
}

void RetainedState::Receive(std::uint32_t number, std::uint32_t sequence,
                            std::uint64_t log_time_ns, std::uint64_t publish_time_ns,
                            ByteView payload) {
  const auto found = learned_.find(number);
  if (found == learned_.end()) return;
  const Learned& learned = found->second;
  std::string key;
  if (learned.keyed && (key = KeyOf(learned, payload)).empty()) return;
  Instance instance{learned.place, std::move(key)};
  if (learned.kind != SampleKind::kValue) {
    Forget(instance);
    return;
  }
  Add(learned, std::move(instance),
      {number, sequence, log_time_ns, publish_time_ns, {payload.begin(), payload.end()}});
}

void RetainedState::Add(const Learned& learned, Instance&& instance,
                        RetainedSample&& sample) {
  const std::uint64_t added = sample.payload.size() + kSampleOverhead;
  const std::uint64_t of_instance =
      instance.first.size() + instance.second.size() + kInstanceOverhead;
  // What does not fit alone may not push all others out.
  if (added + of_instance > max_bytes_) {
    Forget(instance);
    ++forgotten_count_;
    return;
  }
  const auto [at, fresh] = kept_.try_emplace(std::move(instance));
  Kept& kept = at->second;
  if (fresh) {
    kept.bytes = of_instance;
    bytes_ += of_instance;
  } else {
    by_change_.erase(kept.changed);
  }
  kept.samples.emplace_back(++turn_, std::move(sample));
  kept.changed = turn_;
  by_change_.emplace(turn_, &at->first);
  kept.bytes += added;
  bytes_ += added;
  if (kept.samples.size() > learned.depth) {
    const std::uint64_t gone =
        kept.samples.front().second.payload.size() + kSampleOverhead;
    kept.samples.pop_front();
    kept.bytes -= gone;
    bytes_ -= gone;
  }
  while (bytes_ > max_bytes_) {
    Forget(Instance(*by_change_.begin()->second));
    ++forgotten_count_;
  }
}

void RetainedState::Forget(const Instance& instance) {
  const auto found = kept_.find(instance);
  if (found == kept_.end()) return;
  bytes_ -= found->second.bytes;
  by_change_.erase(found->second.changed);
  kept_.erase(found);
}

std::vector<const RetainedSample*> RetainedState::Samples() const {
  std::vector<std::pair<std::uint64_t, const RetainedSample*>> by_turn;
  for (const auto& [instance, kept] : kept_) {
    for (const auto& [turn, sample] : kept.samples) by_turn.emplace_back(turn, &sample);
  }
  std::sort(by_turn.begin(), by_turn.end());
  std::vector<const RetainedSample*> samples;
  for (const auto& [turn, sample] : by_turn) samples.push_back(sample);
  return samples;
}

}  // namespace intaglio::recording
