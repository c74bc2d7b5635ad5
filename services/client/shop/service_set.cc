#include "services/client/shop/service_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/client/proof/evidence/glass_search.h"
#include "services/client/proof/marks/cut_evidence.h"
#include "services/client/proof/marks/mark_search.h"
#include "services/client/shop/shop_snapshot.h"
#include "services/client/shop_flags.h"
#include "services/job/checks/job_check.h"
#include "services/job/files/job_file.h"
#include "services/platform/command_line/other_programs.h"
#include "services/platform/host/process/patience.h"
#include "services/virtual_engraver/truth/truth_file.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr char kMachineFile[] = "machine.textproto";

constexpr auto kReadyTimeout = 30s;
constexpr auto kConsoleTime = 20s;
constexpr std::uint64_t kMaxAddressBytes = 4096;
constexpr auto kLinesTimeout = 10s;
// The job service tries its disk again every second.
constexpr auto kFaultTime = 2500ms;

struct Expected {
  intaglio_ServiceRole role;
  const char* name;
};

/// Marks are made by one process, which has the synchronizer's role; there is no bridge.
const char* NameIn(const MachineSpec& machine, const Expected& expected) {
  if (!machine.has_mark_line()) return expected.name;
  if (expected.role == intaglio_ROLE_MOTION_BRIDGE) return nullptr;
  return expected.role == intaglio_ROLE_SYNCHRONIZER ? "marker" : expected.name;
}
constexpr Expected kExpected[] = {{intaglio_ROLE_JOB_SERVICE, "job-service"},
                                  {intaglio_ROLE_DISCRETIZER, "discretizer"},
                                  {intaglio_ROLE_SORTER, "sorter"},
                                  {intaglio_ROLE_SYNCHRONIZER, "synchronizer"},
                                  {intaglio_ROLE_MOTION_BRIDGE, "motion-bridge"},
                                  {intaglio_ROLE_RECORDER, "recorder"}};

/// Busy: of a queue that was kept it has been given a job already.
bool IsReady(const ServiceView& service) {
  return service.state == intaglio_HEALTH_READY || service.state == intaglio_HEALTH_BUSY;
}

/// Changes when the file is written; empty: there is none.
std::string ConsoleStamp(const fs::path& file) {
  std::error_code error;
  const auto written = fs::last_write_time(file, error);
  return error ? "" : std::to_string(written.time_since_epoch().count());
}

}  // namespace

Status CheckVirtual(const MachineSpec& spec, const VirtualMachine& machine) {
  constexpr const char* kMillProtocol = "grbl-course";
  const std::string& protocol = spec.mark_line().protocol();
  const bool mill = machine.truth.has_mill();
  if (mill && protocol == kMillProtocol && machine.speed == "lockstep") {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("--lockstep: the virtual mill of {} goes by the clock; give "
                            "--speed, e.g. 10, in its place",
                            spec.name()),
                "lockstep");
  }
  if (!spec.has_mark_line() || spec.has_scan_head() ||
      (mill && protocol == kMillProtocol))
    return {};
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("{} has no virtual machine here: of those that mark, scan heads "
                  "have one, and for `intaglio run` mills and cutters with the "
                  "protocol {}; start it with --real-machine on its controller, "
                  "or play the job by `intaglio contour JOB --page FILE`",
                  spec.name(), kMillProtocol),
      protocol);
}

MachineSpec WithKeptTaught(const fs::path& folder, const MachineSpec& machine) {
  const auto before = ReadMachineFile(folder / kMachineFile);
  if (!before || before->name() != machine.name() ||
      before->taught().number() <= machine.taught().number()) {
    return machine;
  }
  MachineSpec kept = machine;
  *kept.mutable_taught() = before->taught();
  return CheckMachine(kept).empty() ? kept : machine;
}

Result<ServiceSet> ServiceSet::Start(const ServiceSetOptions& options,
                                     const VirtualMachine* virtual_machine) {
  ServiceSet set;
  set.machine_ = options.machine;
  set.without_ = options.without;
  set.records_ = !options.recording.empty();
  std::error_code error;
  fs::create_directories(options.folder, error);
  if (!error) fs::create_directories(options.results, error);
  if (error) {
    return Fail(ErrorCode::kIo, fmt::format("cannot make the folder {}: {}",
                                            options.folder.string(), error.message()));
  }
  if (virtual_machine != nullptr) {
    INTAGLIO_TRY(set.StartEngraver(options, *virtual_machine));
  }
  set.machine_file_ = options.folder / kMachineFile;
  INTAGLIO_TRY(WriteMachineFile(set.machine_file_, set.machine_));
  const std::string machine = set.machine_file_.string();
  // A machine that waits for us leaves the processor to the others.
  const bool lockstep =
      virtual_machine != nullptr && virtual_machine->speed == "lockstep";
  std::vector<std::string> at_the_machine = {"--machine", machine};
  std::vector<std::string> of_the_queue = {
      "--database",     (options.folder / "jobs.db").string(),
      "--materials-db", options.materials_db.string(),
      "--results",      options.results.string()};
  if (set.records_) {
    of_the_queue.insert(of_the_queue.end(), {"--recording", options.recording.string()});
  }
  // A machine waits less than a tenth of a second for samples of these services.
  if (!lockstep) {
    for (auto* arguments : {&at_the_machine, &of_the_queue}) {
      arguments->push_back("--real-time");
    }
  }
  // The recorder first: samples sent before it listens are not recorded.
  std::vector<std::pair<std::string, std::vector<std::string>>> services = {
      {"recorder",
       {"--out", options.recording.string(), "--bulk",
        options.recording_bulk.empty() ? "all" : options.recording_bulk}},
      {"job-service", of_the_queue},
      {"discretizer", {}},
      {"sorter", {}}};
  if (set.machine_.has_mark_line()) {
    services.emplace_back("marker", at_the_machine);
  } else {
    services.emplace_back("motion-bridge", at_the_machine);
    services.emplace_back("synchronizer", at_the_machine);
  }
  for (const auto& [name, arguments] : services) {
    if (options.without.contains(name) || (name == "recorder" && !set.records_)) continue;
    INTAGLIO_TRY(set.StartService(options, name, arguments));
  }
  if (options.console.port >= 0) INTAGLIO_TRY(set.StartConsole(options));
  return set;
}

Status ServiceSet::StartEngraver(const ServiceSetOptions& options,
                                 const VirtualMachine& machine) {
  const bool marks = machine_.has_mark_line();
  const bool mill = machine.truth.has_mill();
  INTAGLIO_TRY(CheckVirtual(machine_, machine));
  const fs::path laser = options.folder / "laser", motion = options.folder / "motion";
  const fs::path head = options.folder / (mill ? "mill" : "head");
  panel_ = options.folder / "panel";
  // A job that is open may have cracks in the block of the engraver before, or marks on
  // its piece.
  glass_record_ = options.folder / (mill    ? kCutRecord
                                    : marks ? kMarkRecord
                                            : kGlassRecord);
  if (!mill)
    INTAGLIO_TRY(marks ? KeepMarkRecord(glass_record_) : KeepGlassRecord(glass_record_));
  const fs::path truth = options.folder / "truth.textproto";
  INTAGLIO_TRY(WriteTruthFile(truth, machine.truth));
  ChildProcess::Command command{"virtual-engraver",
                                command_line::ProgramFolder() / "virtual-engraver",
                                {},
                                options.folder / "virtual-engraver.log"};
  command.arguments = {"--truth",       truth.string(), "--panel",
                       panel_.string(), "--speed",      machine.speed};
  const std::vector<std::string> lines =
      mill    ? std::vector<std::string>{"--mill-line", head.string(), "--cut-record",
                                         glass_record_.string()}
      : marks ? std::vector<std::string>{"--head-line", head.string(), "--mark-record",
                                         glass_record_.string()}
              : std::vector<std::string>{"--laser-line",   laser.string(),
                                         "--motion-line",  motion.string(),
                                         "--glass-record", glass_record_.string()};
  command.arguments.insert(command.arguments.end(), lines.begin(), lines.end());
  for (const std::string& fault : machine.faults) {
    command.arguments.insert(command.arguments.end(), {"--fault", fault});
  }
  if (options.die_with_parent) command.arguments.push_back(DieWithUs());
  auto process = ChildProcess::Start(command);
  if (!process && process.error().code == ErrorCode::kNotFound)
    process.error().message += " (Debian package intaglio-virtual-engraver)";
  auto started = INTAGLIO_TRY(std::move(process));
  engraver_.push_back(std::make_unique<ChildProcess>(std::move(started)));
  if (marks) {
    if (!mill) machine_.mutable_mark_line()->set_protocol("scan-head");
    machine_.mutable_mark_line()->set_device(head.string());
    return AwaitLines();
  }
  machine_.mutable_laser_line()->set_protocol("virtual-laser");
  machine_.mutable_laser_line()->set_device(laser.string());
  machine_.mutable_motion_line()->set_protocol("virtual-stage");
  machine_.mutable_motion_line()->set_device(motion.string());
  return AwaitLines();
}

Status ServiceSet::AwaitLines() {
  const auto end = std::chrono::steady_clock::now() + kLinesTimeout;
  const auto is_open = [](const SerialLine& line) { return fs::exists(line.device()); };
  while (machine_.has_mark_line()
             ? !is_open(machine_.mark_line())
             : !is_open(machine_.laser_line()) || !is_open(machine_.motion_line())) {
    if (!engraver_.front()->running()) {
      return tl::unexpected(EndOf(*engraver_.front()));
    }
    if (std::chrono::steady_clock::now() > end) {
      return Fail(ErrorCode::kTimedOut, "the virtual engraver does not open its lines");
    }
    std::this_thread::sleep_for(10ms);
  }
  return {};
}

Status ServiceSet::StartService(const ServiceSetOptions& options, const std::string& name,
                                const std::vector<std::string>& arguments) {
  std::vector<std::string> all = arguments;
  all.insert(all.end(), {"--cell", machine_.name()});
  return Keep(options, name, std::move(all));
}

Status ServiceSet::Keep(const ServiceSetOptions& options, const std::string& name,
                        std::vector<std::string> arguments) {
  const auto shop = ShopArguments(options.bus);
  arguments.insert(arguments.end(), shop.begin(), shop.end());
  if (options.die_with_parent) arguments.push_back(DieWithUs());
  auto started = INTAGLIO_TRY(
      KeptProcess::Start({name, command_line::ProgramFolder() / ("intaglio-" + name),
                          std::move(arguments), options.folder / (name + ".log")}));
  services_.push_back(std::make_unique<KeptProcess>(std::move(started)));
  return {};
}

Status ServiceSet::StartConsole(const ServiceSetOptions& options) {
  console_address_ = options.folder / "console.address";
  console_address_before_ = ConsoleStamp(console_address_);
  const ConsoleSetting& console = options.console;
  const auto users = console.users.empty() ? (options.folder / kConsoleUsersFile).string()
                                           : console.users;
  std::vector<std::string> words = {
      "--port",         std::to_string(console.port),
      "--address-file", console_address_.string(),
      "--users",        users,
      "--audit",        (options.folder / "console_audit.jsonl").string(),
      "--uploads",      (options.folder / "uploads").string(),
      "--database",     (options.folder / "jobs.db").string(),
      "--materials",    options.materials_db.string()};
  const auto add = [&words](const char* option, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {option, value});
  };
  add("--address", console.address);
  add("--certificate", console.certificate);
  add("--private-key", console.private_key);
  add("--webhooks", console.webhooks);
  return Keep(options, "console", std::move(words));
}

Result<std::string> ServiceSet::AwaitConsole() {
  const auto console = std::find_if(
      services_.begin(), services_.end(),
      [](const auto& service) { return service->process().name() == "console"; });
  Require(console != services_.end(), "no console was started");
  for (host::Patience patience(kConsoleTime);
       ConsoleStamp(console_address_) == console_address_before_;) {
    if (!(*console)->process().running())
      return tl::unexpected(EndOf((*console)->process()));
    if (patience.IsUp())
      return Fail(ErrorCode::kTimedOut, "the console does not open: see console.log");
    std::this_thread::sleep_for(10ms);
  }
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(console_address_, kMaxAddressBytes));
  return text.substr(0, text.find('\n'));
}

Result<std::vector<std::string>> ServiceSet::Revive() {
  for (const auto& engraver : engraver_) {
    if (!engraver->running()) return tl::unexpected(EndOf(*engraver));
  }
  std::vector<std::string> revived;
  for (const auto& service : services_) {
    const auto output = service->Revive(std::chrono::steady_clock::now());
    // No job is given up for its recording or its page.
    const std::string& name = service->process().name();
    if (!output && (name == "recorder" || name == "console")) continue;
    if (!output) return tl::unexpected(output.error());
    if (*output) revived.push_back(**output);
  }
  return revived;
}

// One that was started elsewhere, by hand, may name no cell.
bool ServiceSet::IsOurs(const ServiceView& service) const {
  return !IsOfMachine(service) || service.cell.empty() || service.cell == machine_.name();
}

Status ServiceSet::AwaitReady(JobClient& client) {
  std::string missing;
  Status alive;
  std::optional<std::chrono::steady_clock::time_point> faulty_since;
  std::ptrdiff_t ready_count = 0;  // of the whole shop
  const auto ready = [&] {
    if (const auto revived = Revive(); !revived) {
      alive = tl::unexpected(revived.error());
      return true;
    }
    // It waits for room on its disk, or for its folder, and does not end.
    if (auto fault = client.JobServiceFault();
        !fault || without_.contains("job-service")) {
      faulty_since.reset();
    } else if (!faulty_since) {
      faulty_since = std::chrono::steady_clock::now();
    } else if (std::chrono::steady_clock::now() - *faulty_since > kFaultTime) {
      alive = tl::unexpected(std::move(*fault));
      return true;
    }
    missing.clear();
    const auto services = client.services();
    ready_count = std::count_if(services.begin(), services.end(), IsReady);
    for (const Expected& expected : kExpected) {
      const char* name = NameIn(machine_, expected);
      if (name == nullptr || (expected.role == intaglio_ROLE_RECORDER && !records_))
        continue;
      const bool there =
          std::any_of(services.begin(), services.end(), [&](const ServiceView& service) {
            return service.role == expected.role && IsOurs(service) && IsReady(service);
          });
      if (there) continue;
      missing += (missing.empty() ? "" : ", ") + std::string(name);
      for (const ServiceView& service : services) {
        if (service.role == expected.role && IsOurs(service) && !service.message.empty())
          missing += " (" + service.message + ")";
      }
    }
    return missing.empty();
  };
  for (host::Patience patience(kReadyTimeout); !ready(); client.Poll(50ms)) {
    if (!patience.IsUp(ready_count)) continue;
    return Fail(ErrorCode::kTimedOut,
                fmt::format("not ready, and for {:.0f} s no other service became so: {}; "
                            "see the logs beside {}",
                            patience.waited().count(), missing, machine_file_.string()));
  }
  return alive;
}

void ServiceSet::Terminate() {
  for (auto& service : services_) service->process().Terminate();
}

void ServiceSet::EndMaking() {
  Terminate();
  for (auto& service : services_) {
    if (service->process().name() != "recorder") service->process().WaitForEnd(4s);
  }
  std::erase_if(services_, [](const auto& service) {
    return service->process().name() != "recorder";
  });
  engraver_.clear();
}

void ServiceSet::Stop() {
  EndMaking();
  for (auto& service : services_) service->process().WaitForEnd(4s);
  services_.clear();
}

std::vector<std::string> ServiceSet::Processes() {
  std::vector<std::string> lines;
  const auto add = [&](const ChildProcess& process) {
    lines.push_back(fmt::format("{} {}", process.name(), process.pid()));
  };
  for (const auto& engraver : engraver_) add(*engraver);
  for (const auto& service : services_) add(service->process());
  return lines;
}

}  // namespace intaglio::client
