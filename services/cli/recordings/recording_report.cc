#include "services/cli/recordings/recording_report.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "services/client/figure_text.h"
#include "services/platform/recording/conventions.h"

namespace intaglio::cli {
namespace {

std::string UtcText(std::uint64_t ns) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC",
                     fmt::gmtime(static_cast<std::time_t>(ns / 1'000'000'000)));
}

double SecondsOf(const recording::Statistics& statistics) {
  return static_cast<double>(statistics.end_ns - statistics.start_ns) * 1e-9;
}

std::string Entry(const recording::TextMap& entries, const char* name) {
  const auto found = entries.find(name);
  return found == entries.end() ? std::string() : found->second;
}

std::string MissingText(const recording::McapReader& reader) {
  const auto records = reader.ReadMetadata(recording::kMissingRecord);
  if (!records) return fmt::format("damaged     {}\n", records.error().message);
  std::string text;
  for (const recording::Metadata& record : *records) {
    const std::string count = Entry(record.entries, "count");
    text += fmt::format("missing     {}: {}{}\n", Entry(record.entries, "topic"),
                        count.empty() ? "" : count + " messages, ",
                        Entry(record.entries, "reason"));
  }
  return text;
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

std::string RepeatedText(const recording::McapReader& reader) {
  std::string text;
  if (const std::uint64_t count = RepeatedCount(reader.contents()); count > 0) {
    text += fmt::format("repeated    {} more at the beginning, retained from before it\n",
                        client::GroupedDigits(count));
  }
  const auto records = reader.ReadMetadata(recording::kForgottenRecord);
  if (!records) return text;
  for (const recording::Metadata& record : *records) {
    text += fmt::format(
        "forgotten   {} retained samples before file {}: more than {} bytes of them\n",
        Entry(record.entries, "count"), Entry(record.entries, "file_number"),
        Entry(record.entries, "limit_bytes"));
  }
  return text;
}

std::string SummaryState(const recording::RecordingContents& contents) {
  if (contents.complete) return "whole";
  std::string text =
      "open: its writer was killed, is still writing, or the copy was truncated";
  if (contents.torn_bytes > 0) {
    text += fmt::format("; {} bytes at its end are incomplete", contents.torn_bytes);
  }
  return text;
}

}  // namespace

std::string InfoText(const recording::McapReader& reader) {
  const auto& contents = reader.contents();
  const auto& statistics = contents.statistics;
  std::string text =
      fmt::format("file        {}, {} bytes\nstate       {}\nwriter      {}\n",
                  reader.name(), client::GroupedDigits(contents.file_bytes),
                  SummaryState(contents), contents.header.library);
  if (statistics.message_count > 0) {
    text += fmt::format("time        {} to {}, {:.1f} s\n", UtcText(statistics.start_ns),
                        UtcText(statistics.end_ns), SecondsOf(statistics));
  }
  text += fmt::format(
      "messages    {} in {} channels and {} chunks\n",
      client::GroupedDigits(statistics.message_count - RepeatedCount(contents)),
      contents.channels.size(), contents.blocks.size());
  text += RepeatedText(reader);
  for (const auto& attachment : contents.attachments) {
    text += fmt::format("attachment  {}, {} bytes\n", attachment.name,
                        client::GroupedDigits(attachment.content_size));
  }
  text += MissingText(reader);
  for (const std::string& damage : contents.damages) {
    text += fmt::format("damaged     {}\n", damage);
  }
  return text;
}

std::string ChannelTable(const recording::McapReader& reader) {
  const auto& contents = reader.contents();
  const double seconds = SecondsOf(contents.statistics);
  std::vector<const recording::Channel*> channels;
  for (const auto& [id, channel] : contents.channels) channels.push_back(&channel);
  std::sort(channels.begin(), channels.end(),
            [](const auto* a, const auto* b) { return a->topic < b->topic; });
  std::string text = fmt::format("{:<28} {:<10} {:>10} {:>9}  {}\n", "topic", "partition",
                                 "messages", "a second", "type");
  for (const recording::Channel* channel : channels) {
    const std::uint64_t count = CountIn(contents, channel->id);
    const bool repeated = recording::IsRepeated(*channel);
    const recording::Schema* schema = reader.SchemaOf(*channel);
    text +=
        fmt::format("{:<28} {:<10} {:>10} {:>9.1f}  {}\n",
                    channel->topic + (repeated ? ", repeated" : ""),
                    Entry(channel->metadata, "partition"), client::GroupedDigits(count),
                    seconds > 0 && !repeated ? static_cast<double>(count) / seconds : 0.0,
                    schema == nullptr ? "" : schema->name);
  }
  return text;
}

}  // namespace intaglio::cli
