#include "services/cli/recording_command.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>

#include "services/cli/recording_export.h"
#include "services/cli/recording_report.h"
#include "services/cli/run_command.h"
#include "services/recording/recording_copy.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using recording::McapReader;

struct Options {
  std::vector<std::string> files;
  std::string out, format = "jsonl", job, path;
  std::vector<std::string> topics;
  double from_s = 0, to_s = std::numeric_limits<double>::infinity();
};
using Shared = std::shared_ptr<Options>;

Result<std::vector<McapReader>> OpenAll(const Options& options) {
  std::vector<McapReader> readers;
  for (const std::string& file : options.files) {
    auto reader = McapReader::Open(fs::path(file));
    if (!reader) return tl::unexpected(reader.error());
    readers.push_back(std::move(*reader));
  }
  return readers;
}

/// Seconds from the beginning of the recording as log time.
std::uint64_t LogTimeAt(const McapReader& reader, double seconds) {
  if (!std::isfinite(seconds)) return std::numeric_limits<std::uint64_t>::max();
  return reader.contents().statistics.start_ns +
         static_cast<std::uint64_t>(seconds * 1e9);
}

int Print(const Options& options, std::string (*text_of)(const McapReader&)) {
  const auto readers = OpenAll(options);
  if (!readers) return Complain(readers.error());
  for (const McapReader& reader : *readers) std::cout << text_of(reader);
  return kExitGood;
}

int Copy(const Options& options, const std::string& default_ending) {
  const auto readers = OpenAll(options);
  if (!readers) return Complain(readers.error());
  const McapReader& first = readers->front();
  recording::CopyOptions copy;
  copy.library = first.contents().header.library;
  copy.topics = options.topics;
  if (options.from_s > 0) copy.from_ns = LogTimeAt(first, options.from_s);
  copy.to_ns = LogTimeAt(first, options.to_s);
  fs::path out = options.out;
  if (out.empty()) {
    out = fs::path(options.files.front()).replace_extension("").string() + default_ending;
  }
  const auto report = recording::CopyRecordings(*readers, out, copy);
  if (!report) return Complain(report.error());
  for (const std::string& damage : report->damages) {
    std::cerr << "left out    " << damage << "\n";
  }
  fmt::print("{} messages in {}", report->message_count, out.string());
  if (report->repeat_count > 0)
    fmt::print("; {} repeats of messages that are there left out", report->repeat_count);
  fmt::print("\n");
  return kExitGood;
}

Status ExportMessages(const Options& options, const McapReader& reader,
                      std::ostream& out) {
  recording::MessageQuery query;
  if (options.from_s > 0) query.from_ns = LogTimeAt(reader, options.from_s);
  query.to_ns = LogTimeAt(reader, options.to_s);
  auto channels = recording::ChannelsOf(reader, options.topics);
  if (!channels) return tl::unexpected(channels.error());
  query.channels = std::move(*channels);
  if (options.format == "jsonl") return ExportJsonLines(reader, query, out);
  if (options.topics.size() != 1) {
    return Fail(
        ErrorCode::kMissing,
        "a table is of one topic: name it with --topic; `intaglio recording list` "
        "tells what there is");
  }
  return ExportCsv(reader, options.topics.front(), query, out);
}

int Export(const Options& options) {
  const auto readers = OpenAll(options);
  if (!readers) return Complain(readers.error());
  const McapReader& reader = readers->front();
  Status done;
  if (options.format == "ply") {
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
      done = Fail(ErrorCode::kIo,
                  "cannot write " + options.out + "; is there room, and the folder?");
    }
  }
  return done ? kExitGood : Complain(done.error());
}

void AddFile(CLI::App& command, const Shared& options) {
  command.add_option("file", options->files, "recording, .mcap")->required()->expected(1);
}

void AddSpan(CLI::App& command, const Shared& options) {
  command
      .add_option("--from", options->from_s, "seconds after the recording's beginning")
      ->check(CLI::Range(0.0, 1e9));
  command.add_option("--to", options->to_s, "seconds after the recording's beginning")
      ->check(CLI::Range(0.0, 1e9));
  command.add_option("--topic", options->topics, "these topics only");
}

void AddLookCommands(CLI::App& group, std::function<int()>& selected,
                     const Shared& options) {
  CLI::App* info = group.add_subcommand(
      "info", "time, counts, attachments, and what is missing or damaged");
  AddFile(*info, options);
  info->footer("Example: intaglio recording info session.mcap");
  info->callback([options, &selected] {
    selected = [options] { return Print(*options, InfoText); };
  });
  CLI::App* list = group.add_subcommand("list", "topics, with counts and rates");
  AddFile(*list, options);
  list->footer("Example: intaglio recording list session.mcap");
  list->callback([options, &selected] {
    selected = [options] { return Print(*options, ChannelTable); };
  });
  CLI::App* exported =
      group.add_subcommand("export", "messages as JSON lines or a table, or the cracks");
  AddFile(*exported, options);
  AddSpan(*exported, options);
  exported
      ->add_option("--format", options->format,
                   "jsonl; csv: one topic as a table; ply: the pulses that were made")
      ->check(CLI::IsMember({"jsonl", "csv", "ply"}))
      ->capture_default_str();
  exported->add_option("--out", options->out, "file, default standard output");
  exported->add_option("--job", options->job,
                       "of ply: uid of the job, default the first");
  exported->add_option("--path", options->path,
                       "of ply: the job's path.ply, when the recording has no points");
  exported->footer(
      "Example: intaglio recording export session.mcap --topic JobStatus --format csv");
  exported->callback(
      [options, &selected] { selected = [options] { return Export(*options); }; });
}

void AddCopyCommands(CLI::App& group, std::function<int()>& selected,
                     const Shared& options) {
  CLI::App* repair = group.add_subcommand(
      "repair", "a whole file of what can be read of a cut or damaged one");
  AddFile(*repair, options);
  repair->add_option("--out", options->out, "file, default NAME-repaired.mcap");
  repair->footer("Example: intaglio recording repair session.mcap");
  repair->callback([options, &selected] {
    selected = [options] { return Copy(*options, "-repaired.mcap"); };
  });
  CLI::App* merge = group.add_subcommand("merge", "several files as one, by time");
  merge->add_option("files", options->files, "recordings, .mcap")
      ->required()
      ->expected(2, 1000);
  merge->add_option("--out", options->out, "file, default NAME-merged.mcap");
  merge->footer(
      "Example: intaglio recording merge session.mcap session-0002.mcap --out all.mcap");
  merge->callback([options, &selected] {
    selected = [options] { return Copy(*options, "-merged.mcap"); };
  });
  CLI::App* cut = group.add_subcommand("cut", "a span of time, or some topics");
  AddFile(*cut, options);
  AddSpan(*cut, options);
  cut->add_option("--out", options->out, "file, default NAME-cut.mcap");
  cut->footer(
      "Example: intaglio recording cut session.mcap --from 60 --to 90 --out minute.mcap");
  cut->callback([options, &selected] {
    selected = [options] { return Copy(*options, "-cut.mcap"); };
  });
}

}  // namespace

void AddRecordingCommand(CLI::App& app, std::function<int()>& selected) {
  CLI::App* group = app.add_subcommand("recording", "look into a recording, or cut it");
  group->require_subcommand(1);
  const auto options = std::make_shared<Options>();
  AddLookCommands(*group, selected, options);
  AddCopyCommands(*group, selected, options);
  group->footer(
      "Example: intaglio recording export session.mcap --topic JobStatus --format csv\n"
      "Files cut by a kill or a full disk are read as they are; repair makes them quick "
      "to "
      "open.");
}

}  // namespace intaglio::cli
