#include "services/cli/recordings/replay_against.h"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <map>
#include <optional>

#include "engrave/core/try.h"
#include "services/cli/recordings/recording_report.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/child_process.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/job/fields/field_path.h"
#include "services/job/files/job_file.h"
#include "services/job/files/json_text.h"
#include "services/platform/bus/bus.h"
#include "services/platform/command_line/other_programs.h"
#include "services/platform/recording/bulk.h"
#include "services/replayer/cell/cell_rehearsal.h"
#include "services/replayer/rehearsal.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

/// A folder that goes with its holder.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& name)
      : path_(fs::temp_directory_path() / name) {
    fs::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Options of the job are named without its name, all others of the frozen job in full.
Status Change(FrozenJob& job, const std::string& words) {
  const auto at = words.find('=');
  if (at == std::string::npos) {
    return Fail(ErrorCode::kInvalidValue,
                "--set " + words +
                    ": write it as PATH=VALUE, e.g. discretization.min_spacing_mm=0.1",
                words);
  }
  const std::string path = words.substr(0, at), value = words.substr(at + 1);
  if (BeginsWithField(*JobSpec::descriptor(), path))
    return SetField(*job.mutable_job(), path, value);
  return SetField(job, path, value);
}

void PrintCounts(const ReplayComparison& result) {
  std::uint64_t batches = 0, points = 0, runs = 0, segments = 0, pulses = 0;
  for (const TaskComparison& task : result.tasks()) {
    batches += task.batch_count();
    points += task.point_count();
    runs += task.run_count();
    segments += task.segment_count();
    pulses += task.pulse_count();
  }
  const auto tasks = static_cast<std::uint64_t>(result.tasks_size());
  if (result.service() == "synchronizer") {
    fmt::print(std::cout, "{}  {}, {}, {}, {} compared\n", result.service(),
               client::GroupedCount(tasks, "task"), client::GroupedCount(runs, "run"),
               client::GroupedCount(segments, "segment"),
               client::GroupedCount(pulses, "point"));
  } else {
    fmt::print(std::cout, "{}  {}, {}, {} compared\n", result.service(),
               client::GroupedCount(tasks, "task"),
               client::GroupedCount(batches, "batch", "batches"),
               client::GroupedCount(points, "point"));
  }
  for (const TaskComparison& task : result.tasks()) {
    if (!task.recorded_in_part()) continue;
    fmt::print(std::cout, "recorded in part  job {} part {}{}{}\n", task.job_uid(),
               task.part(), task.part_reason().empty() ? "" : ": ", task.part_reason());
  }
}

void PrintFirst(const ReplayComparison& result) {
  const SampleDifference& first = result.first();
  fmt::print(std::cout, "first       {} of job {} attempt {}", first.topic(),
             first.job_uid(), first.attempt());
  if (result.service() == "synchronizer") {
    if (first.run() != 0)
      fmt::print(std::cout, " run {}: place {}", first.run(), first.index());
    if (first.topic() == "PulseEventBatch")
      fmt::print(std::cout, ", point {}", first.point());
  } else {
    fmt::print(std::cout, " part {}: batch {}, point {} ({} of the part)", first.part(),
               first.batch(), first.index(), first.point());
  }
  fmt::print(std::cout, ": {} then {}, now {}\n", first.member(), first.then(),
             first.now());
}

void Print(const ReplayComparison& result) {
  PrintCounts(result);
  fmt::print(std::cout, "version     then {}, now {}\n", result.version_then(),
             result.version_now());
  for (const OptionDifference& option : result.options())
    fmt::print(std::cout, "option      {}: then {}, now {}\n", option.field(),
               option.then(), option.now());
  for (const std::string& input : result.input())
    fmt::print(std::cout, "input       {}\n", input);
  if (result.identical()) {
    fmt::print(std::cout, "verdict     IDENTICAL\n");
    return;
  }
  if (!result.has_first()) {
    fmt::print(std::cout, "verdict     NOT COMPARABLE: {}\n", result.explanation());
    return;
  }
  PrintFirst(result);
  fmt::print(std::cout, "cause       {}: {}\n", result.cause(), result.explanation());
  std::uint64_t different = 0;
  for (const TaskComparison& task : result.tasks())
    different += task.different_batch_count();
  fmt::print(std::cout, "verdict     DIFFERENT");
  if (different > 0)
    fmt::print(std::cout, ", {}", client::GroupedCount(different, "batch", "batches"));
  fmt::print(std::cout, "\n");
}

/// What is compared, bit by bit, is bulk.
Status RequireBulk(const recording::McapReader& reader) {
  const std::string left_out = SentenceOf(recording::BulkRequestOf(reader));
  if (left_out.empty()) return {};
  return Fail(ErrorCode::kMissing, reader.name() + ": nothing to compare: " + left_out +
                                       "; record with --bulk all for --against");
}

struct Bench {
  const AgainstOptions& options;
  const recording::McapReader& reader;
  const bus::BusOptions& bus;
  fs::path folder;
  fs::path laser_line() const { return folder / "laser"; }
};

/// With the machine profile of the session, and a laser line that has no device yet.
Result<client::ChildProcess> StartService(const Bench& bench) {
  const std::string& service = bench.options.service;
  client::ChildProcess::Command command{
      service,
      command_line::ProgramFolder() / ("intaglio-" + service),
      {"--domain", std::to_string(bench.bus.control_domain), "--tag", bench.bus.tag,
       client::DieWithUs()},
      bench.folder / "service.log"};
  if (service == "synchronizer") {
    auto machine = INTAGLIO_TRY(replayer::MachineOf(bench.reader));
    const fs::path file = bench.folder / "machine.textproto";
    INTAGLIO_TRY(WriteMachineFile(file, machine));
    command.arguments.insert(command.arguments.end(),
                             {"--machine", file.string(), "--device",
                              bench.laser_line().string(), "--cell", machine.name()});
  }
  return client::ChildProcess::Start(command);
}

Result<ReplayComparison> Compare(const Bench& bench, bus::Bus& bus,
                                 const replayer::KeepOn& keep_on) {
  std::function<Status(FrozenJob & job)> change;
  if (!bench.options.changes.empty()) {
    change = [&changes = bench.options.changes](FrozenJob& job) -> Status {
      for (const std::string& words : changes) {
        if (auto changed = Change(job, words); !changed) return changed;
      }
      return {};
    };
  }
  if (bench.options.service == "synchronizer") {
    return replayer::RehearseCell(bus, bench.reader,
                                  {bench.laser_line(), bench.folder, std::move(change)},
                                  keep_on);
  }
  const auto stage = bench.options.service == "sorter" ? replayer::Stage::kSort
                                                       : replayer::Stage::kDiscretize;
  return replayer::Rehearse(bus, bench.reader, {stage, std::move(change)}, keep_on);
}

}  // namespace

int ReplayAgainst(const AgainstOptions& options) {
  auto reader = recording::McapReader::Open(fs::path(options.file));
  if (!reader) return Complain(reader.error());
  PrintMissing(*reader);
  if (auto complete = RequireBulk(*reader); !complete) return Complain(complete.error());
  CatchInterrupts();
  bus::BusOptions bus_options;
  bus_options.tag = fmt::format("against-{}", getpid());
  const ScratchFolder folder("intaglio-" + bus_options.tag);
  const Bench bench{options, *reader, bus_options, folder.path()};
  bus::Bus bus(bus_options);
  auto service = StartService(bench);
  if (!service) return Complain(service.error());
  auto result = Compare(bench, bus, [&service]() -> Status {
    if (Interrupts() > 0) return Fail(ErrorCode::kCancelled, "interrupted");
    if (service->running()) return {};
    return Fail(ErrorCode::kFault, "the service ended: " + service->LastOutput());
  });
  if (!result) {
    if (result.error().code == ErrorCode::kCancelled) return client::kExitCancelled;
    const bool service_failed = result.error().code == ErrorCode::kFault ||
                                result.error().code == ErrorCode::kTimedOut;
    return Complain(result.error(),
                    service_failed ? client::kExitMachine : client::kExitWrongInput);
  }
  result->set_recording(options.file);
  if (options.json) {
    const auto text = JsonTextOf(*result);
    if (!text) return Complain(text.error(), client::kExitInternal);
    std::cout << *text << "\n";
  } else {
    Print(*result);
  }
  return result->identical() ? client::kExitGood : client::kExitNotGood;
}

}  // namespace intaglio::cli
