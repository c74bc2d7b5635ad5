#include "services/cli/recordings/recording_report.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <iostream>
#include <limits>
#include <vector>

#include "engrave/core/counted.h"
#include "services/cli/terminal/text_table.h"
#include "services/client/figure_text.h"
#include "services/platform/recording/bulk.h"
#include "services/platform/recording/conventions.h"

namespace intaglio::cli {
namespace {

using recording::McapReader;

/// As host::UtcText, whose clock ends in 2262: times of files go up to 2^64 - 1 ns.
std::string UtcText(std::uint64_t ns) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(static_cast<std::time_t>(ns / 1'000'000'000)),
                     ns / 1'000'000 % 1000);
}

/// "2026-11-23 08:12:57 UTC" of an ISO time.
std::string ForPeople(std::string utc) {
  utc.resize(std::min<std::size_t>(utc.size(), 19));
  if (utc.size() > 10) utc[10] = ' ';
  return utc + " UTC";
}

double SecondsOf(const recording::Statistics& statistics) {
  return static_cast<double>(statistics.end_ns - statistics.start_ns) * 1e-9;
}

std::uint32_t Count32(std::uint64_t count) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(count, std::numeric_limits<std::uint32_t>::max()));
}

std::string Entry(const recording::TextMap& entries, const char* name) {
  const auto found = entries.find(name);
  return found == entries.end() ? std::string() : found->second;
}

/// 0 for an entry that is absent or no number.
std::uint64_t NumberIn(const recording::TextMap& entries, const char* name) {
  const std::string text = Entry(entries, name);
  std::uint64_t number = 0;
  (void)std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

std::uint64_t CountIn(const recording::RecordingContents& contents, std::uint16_t id) {
  const auto found = contents.statistics.message_counts.find(id);
  return found == contents.statistics.message_counts.end() ? 0 : found->second;
}

/// What the file has of an earlier one of its series.
std::uint64_t RepeatedCount(const recording::RecordingContents& contents) {
  std::uint64_t count = 0;
  for (const auto& [id, channel] : contents.channels) {
    if (recording::IsRepeated(channel)) count += CountIn(contents, id);
  }
  // A damaged summary may count otherwise.
  return std::min(count, contents.statistics.message_count);
}

void SetBulk(const McapReader& reader, RecordingBulk& bulk) {
  const recording::BulkRequest request = recording::BulkRequestOf(reader);
  bulk.set_bulk(recording::NameOf(request.bulk));
  bulk.mutable_left_out()->Assign(request.left_out.begin(), request.left_out.end());
  bulk.mutable_thinned()->Assign(request.thinned.begin(), request.thinned.end());
  bulk.set_one_of(request.one_of);
}

/// Missing and forgotten messages, as the recorder wrote them down.
void SetLosses(const McapReader& reader, RecordingInfo& info) {
  const auto missing = reader.ReadMetadata(recording::kMissingRecord);
  if (!missing) info.add_damages(missing.error().message);
  for (const auto& record : missing ? *missing : std::vector<recording::Metadata>()) {
    RecordingMissing& one = *info.add_missing();
    one.set_topic(Entry(record.entries, "topic"));
    one.set_message_count(Count32(NumberIn(record.entries, "count")));
    one.set_reason(Entry(record.entries, "reason"));
  }
  const auto forgotten = reader.ReadMetadata(recording::kForgottenRecord);
  if (!forgotten) return;
  for (const recording::Metadata& record : *forgotten) {
    RecordingForgotten& one = *info.add_forgotten();
    one.set_file_number(Count32(NumberIn(record.entries, "file_number")));
    one.set_message_count(Count32(NumberIn(record.entries, "count")));
    one.set_limit_bytes(NumberIn(record.entries, "limit_bytes"));
  }
}

std::string StateText(const RecordingInfo& info) {
  if (info.whole()) {
    std::uint64_t missing = 0;
    for (const RecordingMissing& one : info.missing()) missing += one.message_count();
    if (missing == 0) return "whole";
    return fmt::format("the file is whole, but {} {} missing in it",
                       client::GroupedCount(missing, "message"), IsOrAre(missing));
  }
  std::string text =
      "open: its writer was killed, is still writing, or the copy was truncated";
  if (info.torn_bytes() > 0) {
    text += fmt::format("; {} at its end {} incomplete",
                        client::GroupedCount(info.torn_bytes(), "byte"),
                        IsOrAre(info.torn_bytes()));
  }
  return text;
}

std::string BulkText(const RecordingBulk& bulk) {
  std::string text;
  if (bulk.left_out_size() > 0) {
    text += fmt::format("left out    by request (--bulk {}): {}\n", bulk.bulk(),
                        fmt::join(bulk.left_out(), ", "));
  }
  if (bulk.thinned_size() > 0) {
    text += fmt::format("thinned     by request (--bulk thin): one message in {} of {}\n",
                        bulk.one_of(), fmt::join(bulk.thinned(), ", "));
  }
  return text;
}

std::string LossText(const RecordingInfo& info) {
  std::string text;
  for (const RecordingForgotten& one : info.forgotten()) {
    text += fmt::format("forgotten   {} before file {}: more than {} bytes of them\n",
                        client::GroupedCount(one.message_count(), "retained sample"),
                        one.file_number(), one.limit_bytes());
  }
  for (const RecordingMissing& one : info.missing()) {
    text += fmt::format("missing     {}: {}{}\n", one.topic(),
                        one.message_count() == 0
                            ? ""
                            : client::GroupedCount(one.message_count(), "message") + ", ",
                        one.reason());
  }
  for (const std::string& damage : info.damages()) {
    text += fmt::format("damaged     {}\n", damage);
  }
  return text;
}

}  // namespace

RecordingInfo InfoOf(const McapReader& reader) {
  const auto& contents = reader.contents();
  const auto& statistics = contents.statistics;
  RecordingInfo info;
  info.set_file(reader.name());
  info.set_bytes(contents.file_bytes);
  info.set_whole(contents.complete);
  info.set_torn_bytes(contents.torn_bytes);
  info.set_writer(contents.header.library);
  if (statistics.message_count > 0) {
    info.set_start_utc(UtcText(statistics.start_ns));
    info.set_end_utc(UtcText(statistics.end_ns));
    info.set_duration_s(SecondsOf(statistics));
  }
  const std::uint64_t repeated = RepeatedCount(contents);
  info.set_message_count(Count32(statistics.message_count - repeated));
  info.set_repeated_count(Count32(repeated));
  info.set_channel_count(Count32(contents.channels.size()));
  info.set_chunk_count(Count32(contents.blocks.size()));
  for (const auto& attachment : contents.attachments) {
    RecordingAttachment& one = *info.add_attachments();
    one.set_name(attachment.name);
    one.set_bytes(attachment.content_size);
  }
  SetBulk(reader, *info.mutable_bulk());
  SetLosses(reader, info);
  for (const std::string& damage : contents.damages) info.add_damages(damage);
  return info;
}

std::string TextOf(const RecordingInfo& info) {
  std::string text = fmt::format("file        {}, {}\nstate       {}\nwriter      {}\n",
                                 info.file(), client::GroupedCount(info.bytes(), "byte"),
                                 StateText(info), info.writer());
  if (!info.start_utc().empty()) {
    text += fmt::format("time        {} to {}, {:.1f} s\n", ForPeople(info.start_utc()),
                        ForPeople(info.end_utc()), info.duration_s());
  }
  text += fmt::format("messages    {} in {} and {}\n",
                      client::GroupedDigits(info.message_count()),
                      Counted(info.channel_count(), "channel"),
                      client::GroupedCount(info.chunk_count(), "chunk"));
  if (info.repeated_count() > 0) {
    text += fmt::format("repeated    {} more at the beginning, retained from before it\n",
                        client::GroupedDigits(info.repeated_count()));
  }
  for (const RecordingAttachment& one : info.attachments()) {
    text += fmt::format("attachment  {}, {}\n", one.name(),
                        client::GroupedCount(one.bytes(), "byte"));
  }
  return text + BulkText(info.bulk()) + LossText(info);
}

RecordingChannels ChannelsIn(const McapReader& reader) {
  const auto& contents = reader.contents();
  const double seconds = SecondsOf(contents.statistics);
  std::vector<const recording::Channel*> by_topic;
  for (const auto& [id, channel] : contents.channels) by_topic.push_back(&channel);
  std::sort(by_topic.begin(), by_topic.end(),
            [](const auto* a, const auto* b) { return a->topic < b->topic; });
  RecordingChannels channels;
  channels.set_file(reader.name());
  for (const recording::Channel* channel : by_topic) {
    const std::uint64_t count = CountIn(contents, channel->id);
    const recording::Schema* schema = reader.SchemaOf(*channel);
    RecordingChannel& one = *channels.add_channels();
    one.set_topic(channel->topic);
    one.set_partition(Entry(channel->metadata, "partition"));
    if (schema != nullptr) one.set_type(schema->name);
    one.set_message_count(Count32(count));
    one.set_repeated(recording::IsRepeated(*channel));
    if (seconds > 0 && !one.repeated()) {
      one.set_messages_per_s(static_cast<double>(count) / seconds);
    }
  }
  SetBulk(reader, *channels.mutable_bulk());
  return channels;
}

std::string TextOf(const RecordingChannels& channels) {
  using Align = TextTable::Align;
  TextTable table({{"topic"},
                   {"partition"},
                   {"messages", Align::kRight},
                   {"a second", Align::kRight},
                   {"type"}});
  for (const RecordingChannel& one : channels.channels()) {
    table.AddRow({one.topic() + (one.repeated() ? ", repeated" : ""), one.partition(),
                  client::GroupedDigits(one.message_count()),
                  fmt::format("{:.1f}", one.messages_per_s()), one.type()});
  }
  return table.Text() + BulkText(channels.bulk());
}

void PrintMissing(const McapReader& reader) {
  for (const std::string& sentence : recording::MissingSentences(reader))
    std::cerr << "warning     " << sentence << "\n";
}

}  // namespace intaglio::cli
