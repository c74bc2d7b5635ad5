#include "services/cli/recordings/recording_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>
#include <set>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/cli/json/print_json.h"
#include "services/cli/recordings/log_time.h"
#include "services/cli/recordings/recording_export.h"
#include "services/cli/recordings/recording_report.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/platform/recording/bulk.h"
#include "services/platform/recording/recording_copy.h"
#include "services/scene/message_schema.h"
#include "services/scene/scene_file.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using recording::McapReader;

struct Options {
  std::vector<std::string> files;
  std::string out, format = "jsonl", job, path;
  std::vector<std::string> topics;
  double from_s = 0, to_s = std::numeric_limits<double>::infinity();
  bool json = false;
};
using Shared = std::shared_ptr<Options>;

Result<std::vector<McapReader>> OpenAll(const Options& options) {
  std::vector<McapReader> readers;
  for (const std::string& file : options.files) {
    auto reader = INTAGLIO_TRY(McapReader::Open(fs::path(file)));
    readers.push_back(std::move(reader));
  }
  return readers;
}

/// Prints what `message_of` makes of one file, for people or for programs.
template <typename Message>
int Print(const Options& options, Message (*message_of)(const McapReader&)) {
  const auto readers = OpenAll(options);
  if (!readers) return Complain(readers.error());
  const Message message = message_of(readers->front());
  if (options.json) return PrintJson(message);
  std::cout << TextOf(message);
  return client::kExitGood;
}

/// What a cut file has lost, for it cannot be read from the file that is made of it.
void PrintTorn(const McapReader& reader) {
  const std::uint64_t bytes = reader.contents().torn_bytes;
  if (bytes == 0) return;
  fmt::print(std::cerr, "left out    {}: {} at its end {} incomplete\n", reader.name(),
             client::GroupedCount(bytes, "byte"), IsOrAre(bytes));
}

recording::MessageQuery SpanOf(const Options& options, const McapReader& reader) {
  recording::MessageQuery query;
  if (options.from_s > 0)
    query.from_ns = LogTimeAt(reader, options.from_s).value_or(UINT64_MAX);
  query.to_ns = LogTimeAt(reader, options.to_s);
  return query;
}

int Copy(const Options& options, const std::string& default_ending) {
  const auto readers = OpenAll(options);
  if (!readers) return Complain(readers.error());
  const McapReader& first = readers->front();
  if (auto span = CheckSpan(first, {"--from", options.from_s}, {"--to", options.to_s});
      !span)
    return Complain(span.error());
  recording::CopyOptions copy;
  copy.library = first.contents().header.library;
  copy.topics = options.topics;
  const recording::MessageQuery span_ns = SpanOf(options, first);
  copy.from_ns = span_ns.from_ns;
  copy.to_ns = span_ns.to_ns;
  fs::path out = options.out;
  if (out.empty()) {
    out = fs::path(options.files.front()).replace_extension("").string() + default_ending;
  }
  const auto report = recording::CopyRecordings(*readers, out, copy);
  if (!report) return Complain(report.error());
  for (const McapReader& reader : *readers) PrintTorn(reader);
  for (const std::string& damage : report->damages) {
    std::cerr << "left out    " << damage << "\n";
  }
  fmt::print(std::cout, "{} in {}",
             client::GroupedCount(report->message_count, "message"), out.string());
  if (report->repeat_count > 0)
    fmt::print(std::cout, "; {} of present messages left out",
               client::GroupedCount(report->repeat_count, "repeat"));
  if (report->copy_count > 0)
    fmt::print(std::cout, "; {} that two of the files have written once",
               client::GroupedCount(report->copy_count, "message"));
  fmt::print(std::cout, "\n");
  return client::kExitGood;
}

/// Without those of a scene, which are none of the bus.
std::set<std::uint16_t> ChannelsOfMessages(const McapReader& reader) {
  std::set<std::uint16_t> ids;
  for (const auto& [id, channel] : reader.contents().channels)
    if (channel.message_encoding != scene::kProtobuf) ids.insert(id);
  return ids;
}

Status ExportMessages(const Options& options, const McapReader& reader,
                      std::ostream& out) {
  recording::MessageQuery query = SpanOf(options, reader);
  const std::string left_out = SentenceOf(recording::BulkRequestOf(reader));
  auto channels = recording::ChannelsOf(reader, options.topics);
  if (!channels) {
    Error error = channels.error();
    if (!left_out.empty()) error.message += "; " + left_out;
    return tl::unexpected(std::move(error));
  }
  if (!left_out.empty()) std::cerr << "note        " << left_out << "\n";
  query.channels =
      options.topics.empty() ? ChannelsOfMessages(reader) : std::move(*channels);
  if (options.format == "jsonl") return ExportJsonLines(reader, query, out);
  if (options.topics.size() != 1) {
    return Fail(ErrorCode::kMissing,
                "a table has one topic: give it with --topic; `intaglio recording list` "
                "lists them");
  }
  return ExportCsv(reader, options.topics.front(), query, out);
}

Status WriteScene(const Options& options, const McapReader& reader) {
  fs::path out = options.out;
  if (out.empty())
    out = fs::path(reader.name()).replace_extension("").string() + "-scene.mcap";
  INTAGLIO_TRY(scene::WriteScene(reader, SpanOf(options, reader), out));
  fmt::print(std::cout, "{}: open it with Foxglove, Lichtblick or Rerun\n", out.string());
  return {};
}

/// An option that another format has would be lost without a word.
Status CheckOptionsOfFormat(const Options& options) {
  struct Option {
    const char* name;
    bool is_given;
    std::vector<std::string> formats;
  };
  for (const auto& [name, is_given, formats] :
       {Option{"--job", !options.job.empty(), {"ply"}},
        Option{"--path", !options.path.empty(), {"ply"}},
        Option{"--topic", !options.topics.empty(), {"jsonl", "csv"}},
        Option{"--from", options.from_s > 0, {"jsonl", "csv", "foxglove"}},
        Option{"--to", std::isfinite(options.to_s), {"jsonl", "csv", "foxglove"}}}) {
    if (!is_given || std::ranges::find(formats, options.format) != formats.end())
      continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{}: --format {} has no such choice; {} is for --format {}",
                            name, options.format, name, fmt::join(formats, " and ")),
                name);
  }
  return {};
}

int Export(const Options& options) {
  if (auto fit = CheckOptionsOfFormat(options); !fit) return Complain(fit.error());
  const auto readers = OpenAll(options);
  if (!readers) return Complain(readers.error());
  const McapReader& reader = readers->front();
  if (auto span = CheckSpan(reader, {"--from", options.from_s}, {"--to", options.to_s});
      !span)
    return Complain(span.error());
  PrintMissing(reader);
  Status done;
  if (options.format == "foxglove") {
    done = WriteScene(options, reader);
  } else if (options.format == "ply") {
    if (options.out.empty()) {
      return Complain({ErrorCode::kMissing, "a PLY needs a file: give --out", ""});
    }
    done = ExportCracks(reader, options.job, options.path, options.out);
  } else if (options.out.empty()) {
    done = ExportMessages(options, reader, std::cout);
  } else {
    std::ofstream out(options.out, std::ios::binary);
    done = ExportMessages(options, reader, out);
    if (done && !out.flush()) {
      done = Fail(ErrorCode::kIo, "cannot write " + options.out +
                                      "; check the folder and the free space");
    }
  }
  return done ? client::kExitGood : Complain(done.error());
}

void AddFile(command_line::Command command, const Shared& options) {
  command.AddOption("file", options->files, "recording, .mcap").Require().TakeValues(1);
}

void AddSpan(command_line::Command command, const Shared& options) {
  command.AddOption("--from", options->from_s, "seconds after the recording's beginning")
      .Within(0.0, 1e9);
  command.AddOption("--to", options->to_s, "seconds after the recording's beginning")
      .Within(0.0, 1e9);
  command.AddOption("--topic", options->topics, "these topics only");
}

void AddReadCommands(command_line::Command group, const Shared& options) {
  command_line::Command info = group.AddCommand(
      "info", "show time, counts, attachments, and what is missing or damaged");
  AddFile(info, options);
  info.AddFlag("--json", options->json, "for programs");
  info.SetFooter("Example: intaglio recording info session.mcap");
  info.SetAction([options] { return Print(*options, InfoOf); });
  command_line::Command list =
      group.AddCommand("list", "list the topics, with counts and rates");
  AddFile(list, options);
  list.AddFlag("--json", options->json, "for programs");
  list.SetFooter("Example: intaglio recording list session.mcap");
  list.SetAction([options] {
    return Print(
        *options, +[](const McapReader& reader) {
          PrintMissing(reader);
          return ChannelsIn(reader);
        });
  });
  command_line::Command exported = group.AddCommand(
      "export", "export messages as JSON lines or a table, or the cracks");
  AddFile(exported, options);
  AddSpan(exported, options);
  exported
      .AddOption("--format", options->format,
                 "jsonl; csv: one topic as a table; ply: the pulses that were made; "
                 "foxglove: a scene for viewers")
      .OneOf({"jsonl", "csv", "ply", "foxglove"})
      .ShowDefault();
  exported.AddOption("--out", options->out,
                     "file, default standard output; of a scene NAME-scene.mcap");
  exported.AddOption("--job", options->job,
                     "for ply: number or uid of the job, needed if there are several");
  exported.AddOption("--path", options->path,
                     "for ply: the job's path.ply, if the recording has no points");
  exported.SetFooter(
      "Example: intaglio recording export session.mcap --topic JobStatus --format csv");
  exported.SetAction([options] { return Export(*options); });
}

void AddCopyCommands(command_line::Command group, const Shared& options) {
  command_line::Command repair = group.AddCommand(
      "repair",
      "write a whole file from the readable part of a truncated or damaged one");
  AddFile(repair, options);
  repair.AddOption("--out", options->out, "file, default NAME-repaired.mcap");
  repair.SetFooter("Example: intaglio recording repair session.mcap");
  repair.SetAction([options] { return Copy(*options, "-repaired.mcap"); });
  command_line::Command merge =
      group.AddCommand("merge", "merge two or more files into one, by time");
  merge.AddOption("files", options->files, "recordings, .mcap")
      .Require()
      .TakeValues(2, 1000);
  merge.AddOption("--out", options->out, "file, default NAME-merged.mcap");
  merge.SetFooter(
      "Example: intaglio recording merge session.mcap session-0002.mcap --out all.mcap");
  merge.SetAction([options] { return Copy(*options, "-merged.mcap"); });
  command_line::Command cut =
      group.AddCommand("cut", "write a span of time, or some topics, to another file");
  AddFile(cut, options);
  AddSpan(cut, options);
  cut.AddOption("--out", options->out, "file, default NAME-cut.mcap");
  cut.SetFooter(
      "Example: intaglio recording cut session.mcap --from 60 --to 90 --out minute.mcap");
  cut.SetAction([options] { return Copy(*options, "-cut.mcap"); });
}

}  // namespace

void AddRecordingCommand(command_line::Command app) {
  command_line::Command group =
      app.AddCommand("recording", "inspect, export, repair, merge or cut recordings");
  group.RequireCommand();
  const auto options = std::make_shared<Options>();
  AddReadCommands(group, options);
  AddCopyCommands(group, options);
  group.SetFooter(
      "Example: intaglio recording export session.mcap --topic JobStatus --format csv\n"
      "Files truncated by a kill or a full disk can be read as they are; repair makes "
      "them faster to open.");
}

}  // namespace intaglio::cli
