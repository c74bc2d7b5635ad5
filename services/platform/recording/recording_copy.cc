#include "services/platform/recording/recording_copy.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <tuple>

#include "engrave/core/try.h"
#include "engrave/io/crc32.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/whole_recording.h"

namespace intaglio::recording {
namespace {

/// One source, with its next message.
struct Source {
  Source(const McapReader& from, MessageQuery query)
      : reader(&from), cursor(from, std::move(query)) {}

  /// Past what cannot be read, which is noted.
  void Advance(std::vector<std::string>& damages) {
    for (;;) {
      auto message = cursor.Next();
      if (message) {
        next = *message;
        return;
      }
      damages.push_back(message.error().message);
    }
  }

  /// At one time originals go first, so that repeats of them are known as such.
  std::pair<std::uint64_t, bool> Place() const {
    return {next->log_time_ns, repeated.contains(next->channel_id)};
  }

  const McapReader* reader;
  MessageCursor cursor;
  std::optional<MessageView> next;
  std::set<std::uint16_t> repeated;                // channels of repeats
  std::map<std::uint16_t, std::uint32_t> stream;   // of repeats and originals
  std::map<std::uint16_t, std::uint16_t> channel;  // in the target, by that of the source
};

/// The samples that some source repeats, to be written once.
class Repeats {
 public:
  /// Before the source's first message is asked for.
  void Expect(Source& source, const MessageQuery& query) {
    for (const auto& [id, channel] : source.reader->contents().channels) {
      const auto stream = StreamOf(channel);
      if (!stream || stream->kind != SampleKind::kValue ||
          (query.channels && !query.channels->contains(id)))
        continue;
      const auto number = static_cast<std::uint32_t>(numbers_.size());
      source.stream[id] =
          numbers_
              .try_emplace(std::tuple(stream->topic, stream->partition, stream->bulk),
                           number)
              .first->second;
      if (stream->repeated) source.repeated.insert(id);
    }
    if (source.repeated.empty()) return;
    MessageCursor cursor(*source.reader, {query.from_ns, query.to_ns, source.repeated});
    for (;;) {
      const auto message = cursor.Next();
      if (!message) continue;  // reported when it is copied
      if (!*message) return;
      const std::uint32_t stream = source.stream.at((*message)->channel_id);
      written_[stream].emplace(IdOf(**message), false);
    }
  }
  /// Is it in the target already?
  bool IsAgain(const Source& source, const MessageView& message) {
    const auto stream = source.stream.find(message.channel_id);
    if (stream == source.stream.end()) return false;
    const auto expected = written_.find(stream->second);
    if (expected == written_.end()) return false;
    const auto found = expected->second.find(IdOf(message));
    if (found == expected->second.end()) return false;
    if (found->second && source.repeated.contains(message.channel_id)) return true;
    found->second = true;
    return false;
  }

 private:
  using Id = std::tuple<std::uint32_t, std::uint64_t, std::uint32_t>;
  static Id IdOf(const MessageView& message) {
    return {message.sequence, message.publish_time_ns, io::Crc32(message.payload)};
  }
  std::map<std::tuple<std::string, std::string, bool>, std::uint32_t> numbers_;
  std::map<std::uint32_t, std::map<Id, bool>> written_;  // by number of the stream
};

class Copy {
 public:
  Copy(McapWriter& writer, const CopyOptions& options)
      : writer_(writer), options_(options) {}

  Status Add(const McapReader& reader) {
    auto channels = INTAGLIO_TRY(ChannelsOf(reader, options_.topics));
    const auto& damages = reader.contents().damages;
    report_.damages.insert(report_.damages.end(), damages.begin(), damages.end());
    const MessageQuery query{options_.from_ns, options_.to_ns, std::move(channels)};
    Source& source = sources_.emplace_back(reader, query);
    repeats_.Expect(source, query);
    source.Advance(report_.damages);
    INTAGLIO_TRY(CopyMetadata(reader));
    return CopyAttachments(reader);
  }

  Result<CopyReport> Run() {
    for (;;) {
      const auto first = std::min_element(sources_.begin(), sources_.end(),
                                          [](const Source& a, const Source& b) {
                                            if (!a.next || !b.next)
                                              return a.next.has_value();
                                            return a.Place() < b.Place();
                                          });
      if (first == sources_.end() || !first->next) return std::move(report_);
      MessageView message = *first->next;
      if (repeats_.IsAgain(*first, message)) {
        ++report_.repeat_count;
        first->Advance(report_.damages);
        continue;
      }
      message.channel_id = TargetOf(*first, message.channel_id);
      if (IsCopy(*first, message)) {
        ++report_.copy_count;
        first->Advance(report_.damages);
        continue;
      }
      INTAGLIO_TRY(writer_.Write(message));
      ++report_.message_count;
      first->Advance(report_.damages);
    }
  }

 private:
  /// Another source had the same message at the same time: one of the two is a copy of
  /// the other, or both are parts of one recording. `message` is in a channel of the
  /// target.
  bool IsCopy(const Source& source, const MessageView& message) {
    if (sources_.size() < 2) return false;
    if (message.log_time_ns != time_ns_) at_time_.clear();
    time_ns_ = message.log_time_ns;
    const auto [known, added] = at_time_.try_emplace(
        std::tuple(message.channel_id, message.sequence, message.publish_time_ns,
                   io::Crc32(message.payload)),
        &source);
    return !added && known->second != &source;
  }

  std::uint16_t TargetOf(Source& source, std::uint16_t id) {
    const auto [known, added] = source.channel.try_emplace(id, 0);
    if (!added) return known->second;
    Channel channel = source.reader->contents().channels.at(id);
    const Schema* schema = source.reader->SchemaOf(channel);
    channel.schema_id =
        schema == nullptr
            ? std::uint16_t{0}
            : writer_.AddSchema(schema->name, schema->encoding, schema->text);
    const auto stream = StreamOf(channel);
    const Lane lane = stream && stream->bulk ? Lane::kLarge : Lane::kSmall;
    return known->second = writer_.AddChannel(std::move(channel), lane);
  }

  Status CopyMetadata(const McapReader& reader) {
    for (const MetadataIndex& index : reader.contents().metadata) {
      auto metadata = reader.Read(index);
      if (!metadata) {
        report_.damages.push_back(metadata.error().message);
        continue;
      }
      if (std::find(metadata_.begin(), metadata_.end(), *metadata) != metadata_.end())
        continue;
      INTAGLIO_TRY(writer_.Write(*metadata));
      metadata_.push_back(std::move(*metadata));
    }
    return {};
  }

  Status CopyAttachments(const McapReader& reader) {
    for (const AttachmentIndex& index : reader.contents().attachments) {
      const auto attachment = reader.Read(index);
      if (!attachment) {
        report_.damages.push_back(attachment.error().message);
        continue;
      }
      const std::pair alike(attachment->name, io::Crc32(attachment->content));
      if (!attachments_.insert(alike).second) continue;
      if (auto written = writer_.Write(*attachment); !written) return written;
    }
    return {};
  }

  McapWriter& writer_;
  const CopyOptions& options_;
  std::deque<Source> sources_;
  Repeats repeats_;
  std::uint64_t time_ns_ = 0;
  /// What the source wrote first at time_ns_: channel, sequence, publish time, checksum.
  std::map<std::tuple<std::uint16_t, std::uint32_t, std::uint64_t, std::uint32_t>,
           const Source*>
      at_time_;
  std::vector<Metadata> metadata_;
  std::set<std::pair<std::string, std::uint32_t>> attachments_;
  CopyReport report_;
};

}  // namespace

Result<std::optional<std::set<std::uint16_t>>> ChannelsOf(
    const McapReader& reader, const std::vector<std::string>& topics) {
  if (topics.empty()) return std::nullopt;
  std::set<std::uint16_t> ids;
  for (const std::string& topic : topics) {
    bool found = false;
    for (const auto& [id, channel] : reader.contents().channels) {
      if (channel.topic != topic && !channel.topic.starts_with(topic + "/")) continue;
      ids.insert(id);
      found = true;
    }
    if (!found) {
      return Fail(
          ErrorCode::kNotFound,
          fmt::format("{} has no topic {}; `intaglio recording list` lists its topics",
                      reader.name(), topic),
          topic);
    }
  }
  return ids;
}

Result<CopyReport> CopyRecordings(const std::vector<McapReader>& sources,
                                  const std::filesystem::path& target,
                                  const CopyOptions& options) {
  std::vector<std::string> names;
  for (const McapReader& source : sources) names.push_back(source.name());
  CopyReport report;
  const auto copy_all = [&](McapWriter& writer) -> Status {
    Copy copy(writer, options);
    for (const McapReader& source : sources) INTAGLIO_TRY(copy.Add(source));
    report = INTAGLIO_TRY(copy.Run());
    return {};
  };
  INTAGLIO_TRY(WriteWhole(names, target, options.library, copy_all));
  return report;
}

}  // namespace intaglio::recording
