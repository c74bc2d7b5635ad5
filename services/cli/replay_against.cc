#include "services/cli/replay_against.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <map>
#include <optional>

#include "proto/field_path.h"
#include "proto/json_text.h"
#include "services/bus/bus.h"
#include "services/cli/child_process.h"
#include "services/cli/interrupt.h"
#include "services/cli/run_command.h"
#include "services/replayer/rehearsal.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

int Complain(const Error& error, int code = kExitWrongInput) {
  std::cerr << "intaglio: " << error.message << "\n";
  return code;
}

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
                    ": say it as PATH=VALUE, e.g. discretization.min_spacing_mm=0.1",
                words);
  }
  const std::string path = words.substr(0, at), value = words.substr(at + 1);
  if (BeginsWithField(*JobSpec::descriptor(), path))
    return SetField(*job.mutable_job(), path, value);
  return SetField(job, path, value);
}

void Print(const ReplayComparison& result) {
  std::uint64_t batches = 0, points = 0, different = 0;
  for (const TaskComparison& task : result.tasks()) {
    batches += task.batch_count();
    points += task.point_count();
    different += task.different_batch_count();
  }
  fmt::print("{}  {} tasks, {} batches, {} points compared\n", result.service(),
             result.tasks_size(), batches, points);
  for (const TaskComparison& task : result.tasks()) {
    if (task.recorded_in_part())
      fmt::print("recorded in part  job {} part {}\n", task.job_uid(), task.part());
  }
  fmt::print("version     then {}, now {}\n", result.version_then(),
             result.version_now());
  for (const OptionDifference& option : result.options())
    fmt::print("option      {}: then {}, now {}\n", option.field(), option.then(),
               option.now());
  for (const std::string& input : result.input()) fmt::print("input       {}\n", input);
  if (result.identical()) {
    fmt::print("verdict     IDENTICAL\n");
    return;
  }
  if (result.has_first()) {
    const SampleDifference& first = result.first();
    fmt::print(
        "first       {} of job {} attempt {} part {}: batch {}, point {} ({} of the "
        "part): {} then {}, now {}\n",
        first.topic(), first.job_uid(), first.attempt(), first.part(), first.batch(),
        first.index(), first.point(), first.member(), first.then(), first.now());
  }
  fmt::print("cause       {}: {}\n", result.cause(), result.explanation());
  fmt::print("verdict     DIFFERENT, {} batches\n", different);
}

ChildProcess::Command CommandOf(const AgainstOptions& options, const bus::BusOptions& bus,
                                const fs::path& folder) {
  return {options.service,
          ProgramFolder() / ("intaglio-" + options.service),
          {"--domain", std::to_string(bus.control_domain), "--tag", bus.tag,
           "--die-with-parent"},
          folder / "service.log"};
}

}  // namespace

int ReplayAgainst(const AgainstOptions& options) {
  auto reader = recording::McapReader::Open(fs::path(options.file));
  if (!reader) return Complain(reader.error());
  CatchInterrupts();
  bus::BusOptions bus_options;
  bus_options.tag = fmt::format("against-{}", getpid());
  const ScratchFolder folder("intaglio-" + bus_options.tag);
  bus::Bus bus(bus_options);
  auto service = ChildProcess::Start(CommandOf(options, bus_options, folder.path()));
  if (!service) return Complain(service.error());
  replayer::RehearsalOptions rehearsal;
  rehearsal.stage =
      options.service == "sorter" ? replayer::Stage::kSort : replayer::Stage::kDiscretize;
  if (!options.changes.empty()) {
    rehearsal.change = [&options](FrozenJob& job) -> Status {
      for (const std::string& words : options.changes) {
        if (auto changed = Change(job, words); !changed) return changed;
      }
      return {};
    };
  }
  auto result = replayer::Rehearse(bus, *reader, rehearsal, [&service]() -> Status {
    if (Interrupts() > 0) return Fail(ErrorCode::kCancelled, "interrupted");
    if (service->running()) return {};
    return Fail(ErrorCode::kFault, "the service ended: " + service->LastOutput());
  });
  if (!result) {
    if (result.error().code == ErrorCode::kCancelled) return kExitCancelled;
    const bool service_failed = result.error().code == ErrorCode::kFault ||
                                result.error().code == ErrorCode::kTimedOut;
    return Complain(result.error(), service_failed ? kExitMachine : kExitWrongInput);
  }
  result->set_recording(options.file);
  if (options.json) {
    const auto text = JsonTextOf(*result);
    if (!text) return Complain(text.error(), kExitInternal);
    std::cout << *text << "\n";
  } else {
    Print(*result);
  }
  return result->identical() ? kExitGood : kExitNotGood;
}

}  // namespace intaglio::cli
