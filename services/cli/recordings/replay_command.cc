#include "services/cli/recordings/replay_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engrave/core/try.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/recordings/log_time.h"
#include "services/cli/recordings/recording_report.h"
#include "services/cli/recordings/replay_against.h"
#include "services/cli/terminal/command_outcome.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/platform/recording/bulk.h"
#include "services/replayer/live_services.h"
#include "services/replayer/player.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;
using recording::McapReader;
using Clock = std::chrono::steady_clock;

struct ReplayOptions {
  bus::BusOptions bus;
  std::string file;
  double rate = 1, start_s = 0, stop_s = std::numeric_limits<double>::infinity();
  bool fast = false, loop = false, step = false, with_commands = false;
  std::vector<std::string> topics, without, renames;
  AgainstOptions against;
};

Result<std::map<std::string, std::string>> RenamesOf(
    const std::vector<std::string>& words) {
  std::map<std::string, std::string> renames;
  for (const std::string& word : words) {
    const auto at = word.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == word.size()) {
      return Fail(
          ErrorCode::kInvalidValue,
          "--rename " + word + ": write it as OLD=NEW, e.g. JobStatus=Old/JobStatus",
          word);
    }
    renames[word.substr(0, at)] = word.substr(at + 1);
  }
  return renames;
}

std::string Listed(const std::map<std::string, std::string>& live_services) {
  std::string text;
  for (const auto& [instance, words] : live_services)
    text += (text.empty() ? "" : ", ") + words;
  return text;
}

/// Enter plays the next sample, a number so many; the end of the input ends.
class Stepper {
 public:
  explicit Stepper(std::uint64_t start_ns) : start_ns_(start_ns) {}

  bool Admit(const replayer::PlayedChannel& channel, std::uint64_t log_time_ns) {
    if (left_ == 0) {
      std::cout << fmt::format("{:12.6f} s  {}{}{}\n",
                               static_cast<double>(log_time_ns - start_ns_) / 1e9,
                               channel.name,
                               channel.stream.partition.empty() ? "" : " in ",
                               channel.stream.partition)
                << std::flush;
      std::string line;
      if (!std::getline(std::cin, line) || line == "q") return false;
      left_ = std::max(1ul, std::strtoul(line.c_str(), nullptr, 10));
    }
    --left_;
    return true;
  }

 private:
  std::uint64_t start_ns_;
  unsigned long left_ = 0;
};

/// One replay with all that belongs to it.
class Replay {
 public:
  Replay(const ReplayOptions& options, McapReader reader)
      : options_(options),
        reader_(std::move(reader)),
        bus_(options.bus),
        publisher_(bus_),
        live_services_(bus_) {}

  int Run();

 private:
  bool Wait(std::chrono::milliseconds time);
  bool KeepOn();
  Result<replayer::Selection> Choose();
  void Print(const replayer::PlayReport& report) const;
  int EndCode(const replayer::PlayReport& report) const;

  const ReplayOptions& options_;
  McapReader reader_;
  bus::Bus bus_;
  bus::CdrPublisher publisher_;
  replayer::LiveServices live_services_;
  bool believed_ = false;
  std::string intruders_;  // services that came while something they believe was played
  Clock::time_point checked_{};
};

bool Replay::Wait(std::chrono::milliseconds time) {
  const auto end = Clock::now() + time;
  while (Clock::now() < end && Interrupts() == 0) std::this_thread::sleep_for(10ms);
  return Interrupts() == 0;
}

bool Replay::KeepOn() {
  if (Interrupts() > 0 || !intruders_.empty()) return false;
  const auto now = Clock::now();
  if (now - checked_ < 50ms) return true;
  checked_ = now;
  const auto& there = live_services_.Read();
  if (believed_ && !options_.with_commands && !there.empty()) intruders_ = Listed(there);
  return intruders_.empty();
}

Result<replayer::Selection> Replay::Choose() {
  replayer::SelectionOptions chosen;
  chosen.topics = {options_.topics, options_.without};
  auto renames = INTAGLIO_TRY(RenamesOf(options_.renames));
  chosen.renames = std::move(renames);
  chosen.with_commands = options_.with_commands;
  chosen.credit_is_given = options_.fast;
  const auto& there = live_services_.Read();
  chosen.services_live = !there.empty();
  auto selection = replayer::Select(reader_.contents(), chosen);
  if (!selection) return selection;
  if (!there.empty()) {
    std::cerr << "on this bus: " << Listed(there)
              << (options_.with_commands ? "; they will obey the played commands\n"
                                         : "\n");
  }
  if (const auto bulk = SentenceOf(recording::BulkRequestOf(reader_)); !bulk.empty()) {
    std::cerr << "not played  " << bulk << "\n";
  }
  for (const auto& [topic, why] : selection->left_out) {
    if (why != "not selected")
      std::cerr << fmt::format("left out    {}: {}\n", topic, why);
  }
  if (selection->channels.empty()) {
    const bool none_chosen = std::ranges::all_of(
        selection->left_out,
        [](const auto& topic) { return topic.second == "not selected"; });
    if (none_chosen && !options_.topics.empty()) {
      return Fail(ErrorCode::kNotFound,
                  fmt::format("--topic {}: {} has no such topic; `intaglio recording "
                              "list` lists its topics",
                              fmt::join(options_.topics, ", "), options_.file));
    }
    return Fail(ErrorCode::kMissing, chosen.services_live
                                         ? "nothing may be played beside these live "
                                           "services: use another --domain or --tag"
                                         : "nothing remains to play");
  }
  return selection;
}

void Replay::Print(const replayer::PlayReport& report) const {
  for (const std::string& complaint : report.complaints)
    Complain({ErrorCode::kUnreadable, complaint, ""});
  if (report.restored_count > 0)
    fmt::print(std::cout, "{}, ",
               client::GroupedCount(report.restored_count, "retained sample"));
  fmt::print(std::cout, "{} played\n",
             client::GroupedCount(report.played_count, "sample"));
  std::cout << std::flush;
}

int Replay::EndCode(const replayer::PlayReport& report) const {
  if (!intruders_.empty()) {
    return Complain({ErrorCode::kRefused,
                     fmt::format("stopped, because live services appeared that would use "
                                 "the played state: {}; use another --domain or --tag",
                                 intruders_),
                     ""},
                    client::kExitMachine);
  }
  if (Interrupts() > 0) return client::kExitCancelled;
  return report.complaints.empty() || report.played_count > 0 ? client::kExitGood
                                                              : client::kExitWrongInput;
}

int Replay::Run() {
  PrintMissing(reader_);
  if (!Wait(bus_.discovery_time())) return client::kExitCancelled;
  auto selection = Choose();
  if (!selection) return Complain(selection.error());
  believed_ = selection->believed;
  const auto player =
      replayer::Player::Make(bus_, publisher_, reader_, std::move(*selection));
  if (!player) return Complain(player.error());
  // The participants know each other by now; what is new are the writers.
  if (!Wait(bus_.discovery_time() / 3)) return client::kExitCancelled;
  replayer::PlayOptions play;
  if (options_.start_s > 0)
    play.from_ns = LogTimeAt(reader_, options_.start_s).value_or(UINT64_MAX);
  play.to_ns = LogTimeAt(reader_, options_.stop_s);
  play.rate = options_.rate;
  play.by_credit = options_.fast || options_.step;
  Stepper stepper(reader_.contents().statistics.start_ns);
  replayer::PlayHooks hooks;
  hooks.keep_on = [this] { return KeepOn(); };
  if (options_.step) {
    hooks.admit = [&stepper](const auto& channel, std::uint64_t log_time_ns) {
      return stepper.Admit(channel, log_time_ns);
    };
  }
  for (;;) {
    const auto report = (*player)->Play(play, hooks);
    Print(report);
    if (options_.loop && report.whole && report.played_count > 0) continue;
    (*player)->Settle(5s);
    return EndCode(report);
  }
}

int Run(const ReplayOptions& options) {
  if (!options.against.service.empty()) {
    AgainstOptions against = options.against;
    against.file = options.file;
    return ReplayAgainst(against);
  }
  AnswerWithText();
  auto reader = McapReader::Open(std::filesystem::path(options.file));
  if (!reader) return Complain(reader.error());
  if (auto span =
          CheckSpan(*reader, {"--start", options.start_s}, {"--stop", options.stop_s});
      !span)
    return Complain(span.error());
  CatchInterrupts();
  return Replay(options, std::move(*reader)).Run();
}

void AddFlags(command_line::Command replay, ReplayOptions& options) {
  replay.AddOption("file", options.file, "recording, .mcap").Require();
  const auto rate = replay.AddOption("--rate", options.rate, "multiple of real time")
                        .Within(1e-3, 1e3)
                        .ShowDefault();
  const auto fast = replay.AddFlag("--fast", options.fast,
                                   "as fast as the consumers of points grant credit");
  const auto step = replay.AddFlag(
      "--step", options.step, "one sample at each Enter, N samples at N Enter; q ends");
  rate.Exclude(fast).Exclude(step);
  replay
      .AddOption("--start", options.start_s,
                 "seconds after the beginning; the samples retained at that time are "
                 "played first")
      .Within(0.0, 1e9);
  replay.AddOption("--stop", options.stop_s, "seconds after the beginning")
      .Within(0.0, 1e9);
  replay.AddFlag("--loop", options.loop, "repeat until Ctrl-C");
  replay.AddOption("--topic", options.topics,
                   "these topics only; a name, or a pattern with * and ?");
  replay.AddOption("--without-topic", options.without, "all topics but these");
  replay.AddOption("--rename", options.renames, "OLD=NEW: publish under another name");
  replay.AddFlag(
      "--with-commands", options.with_commands,
      "also play what machines and services obey: tasks, commands, permission, motion");
}

void AddAgainstFlags(command_line::Command replay, AgainstOptions& options) {
  const auto against = replay
                           .AddOption("--against", options.service,
                                      "sorter, discretizer or synchronizer: compare what "
                                      "it makes today with the recording, bit by bit")
                           .OneOf({"sorter", "discretizer", "synchronizer"});
  replay
      .AddOption("--set", options.changes,
                 "PATH=VALUE: with another option of the job, e.g. "
                 "discretization.min_spacing_mm=0.1")
      .Need(against);
  replay.AddFlag("--json", options.json,
                 "for programs: the comparison of --against, else a CommandAnswer");
}

}  // namespace

void AddReplayCommand(command_line::Command app) {
  auto options = std::make_shared<ReplayOptions>();
  command_line::Command replay =
      app.AddCommand("replay", "put a recording back on a bus");
  AddBusFlags(replay, options->bus);
  AddFlags(replay, *options);
  AddAgainstFlags(replay, options->against);
  replay.SetFooter(
      "Example: intaglio replay session.mcap --tag replay --rate 10\n"
      "Commands to machines are played only with --with-commands. If services are live, "
      "their state and that of the machine is not played, either.\n"
      "With --against the service runs alone on a private bus. Exit 0: identical; 3: "
      "different, and the report gives place and cause.");
  replay.SetAction([options] { return Run(*options); });
}

}  // namespace intaglio::cli
