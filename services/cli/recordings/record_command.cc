#include "services/cli/recordings/record_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <ctime>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "services/cli/flags/bulk_flag.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/platform/command_line/other_programs.h"

namespace intaglio::cli {
namespace {

/// A flag that the recorder has, too; it checks the values.
struct Handed {
  const char* flag;
  const char* help;
  std::vector<std::string> values = {};
};

struct RecordOptions {
  bus::BusOptions bus;
  std::string out;
  std::vector<Handed> handed = {
      {"--topic", "record these topics only; a name, or a pattern with * and ?"},
      {"--not-topic", "record all topics but these"},
      {"--partition", "record these cells only"},
      {"--not-partition", "record all cells but these"},
      {"--type", "record these types only, e.g. intaglio::JobStatus"},
      {"--not-type", "record all types but these"},
      {"--split-mb", "begin a new file at this size, MB"},
      {"--split-min", "begin a new file after this time, minutes"},
      {"--keep-mb", "remove the oldest files beyond this size together, MB"},
      {"--keep-h", "remove files not written for this many hours"},
      {"--queue-mb", "memory for messages that wait for the disk, MB, default 64"},
      {"--compression", "level of zstd, 0 to 19, default 1; 0: none"}};
  std::string bulk;
  bool scene = false;
};

std::string DefaultFile() {
  return fmt::format("recording-{:%Y%m%d-%H%M%S}.mcap", fmt::gmtime(std::time(nullptr)));
}

int Record(const RecordOptions& options) {
  const std::string program =
      (command_line::ProgramFolder() / "intaglio-recorder").string();
  std::vector<std::string> words = {program,
                                    "--out",
                                    options.out.empty() ? DefaultFile() : options.out,
                                    "--domain",
                                    std::to_string(options.bus.control_domain),
                                    "--interface",
                                    options.bus.interface};
  const auto add = [&words](const char* flag, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  };
  add("--tag", options.bus.tag);
  add("--security", options.bus.security);
  add("--bulk", options.bulk);
  if (options.scene) words.push_back("--scene");
  for (const Handed& handed : options.handed) {
    for (const std::string& value : handed.values) add(handed.flag, value);
  }
  const std::vector<char*> argv = command_line::PointersTo(words);
  execv(program.c_str(), argv.data());
  return Complain({ErrorCode::kIo,
                   fmt::format("cannot start {}: {}; it has to be in the folder of "
                               "intaglio",
                               program, std::strerror(errno)),
                   program},
                  client::kExitInternal);
}

}  // namespace

void AddRecordCommand(command_line::Command app) {
  auto options = std::make_shared<RecordOptions>();
  command_line::Command record =
      app.AddCommand("record", "record all messages of a shop, until Ctrl-C");
  AddBusFlags(record, options->bus);
  record.AddOption(
      "--out", options->out,
      "file, default recording-TIME.mcap; if it exists, NAME-0002.mcap and so on");
  for (Handed& handed : options->handed) {
    record.AddOption(handed.flag, handed.values, handed.help);
  }
  AddBulkFlag(record, options->bulk);
  record.AddFlag("--scene", options->scene,
                 "also the jobs as a scene for Foxglove, Lichtblick and Rerun");
  record.SetFooter(
      "Example: intaglio record --out night.mcap --split-min 60 --keep-mb 20000\n"
      "It delays no other process: if the disk is too slow, models and points are left "
      "out, and the file records what is missing (`intaglio recording info FILE`).");
  record.SetAction([options] { return Record(*options); });
}

}  // namespace intaglio::cli
