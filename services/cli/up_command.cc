#include "services/cli/up_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "materials_db/material_store.h"
#include "services/cli/flags/bulk_flag.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/flags/console_flag.h"
#include "services/cli/flags/customer_picture_flags.h"
#include "services/cli/flags/truth_flags.h"
#include "services/cli/job/job_options.h"
#include "services/cli/job/job_series.h"
#include "services/cli/proofs/cell_proofs.h"
#include "services/cli/teach/mount_command.h"
#include "services/cli/teach/mounted.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/client/fresh_paths.h"
#include "services/client/job_client.h"
#include "services/client/locks/folder_lock.h"
#include "services/client/shop/shop_cells.h"
#include "services/client/shop/virtual_truth.h"
#include "services/history/job_database.h"
#include "services/job/files/job_file.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// A shop that was killed a moment ago needs this long to go.
constexpr auto kLeaveTime = 5s;
// A process that still publishes this long after it was found has not been killed; five
// samples.
constexpr auto kGoesOnTime = 1s;
struct UpOptions {
  bus::BusOptions bus;
  std::string machine = "els-03";
  std::string folder = "intaglio-shop";
  std::string materials_db;
  std::vector<std::string> without;
  bool real_machine = false;
  bool is_virtual = false;
  int cells = 1;
  bool lockstep = false;
  bool record = false;
  std::string bulk;
  ConsoleFlags console;
  double speed = 1;
  TruthFlags truth;
  MountFlags mount;
  CustomerPictureFlags picture;
};

Result<client::VirtualMachine> MachineOf(const UpOptions& options,
                                         const MachineSpec& machine,
                                         const MountedParts& mounted) {
  client::VirtualMachine virtual_machine;
  virtual_machine.truth =
      client::TruthOf(INTAGLIO_TRY(MachineSetTo(options.mount, machine)), mounted);
  INTAGLIO_TRY(options.truth.Change(virtual_machine.truth));
  virtual_machine.speed =
      options.lockstep ? "lockstep" : fmt::format("{}", options.speed);
  INTAGLIO_TRY(client::CheckVirtual(machine, virtual_machine));
  return virtual_machine;
}

/// A second job service would take every submission again, a second synchronizer would
/// fire the same laser.
std::optional<client::ServiceView> RivalOf(const client::ServiceSetOptions& set,
                                           const std::set<std::string>& cells,
                                           const client::JobClient& client) {
  for (const client::ServiceView& service : client.services()) {
    const bool of_shop =
        service.role == intaglio_ROLE_JOB_SERVICE && !set.without.contains("job-service");
    const bool of_cell =
        cells.contains(service.cell) && ((service.role == intaglio_ROLE_SYNCHRONIZER &&
                                          !set.without.contains("synchronizer")) ||
                                         (service.role == intaglio_ROLE_MOTION_BRIDGE &&
                                          !set.without.contains("motion-bridge")));
    if (of_shop || of_cell) return service;
  }
  return std::nullopt;
}

Status AwaitNoRival(const client::ServiceSetOptions& set,
                    const std::set<std::string>& cells, client::JobClient& client,
                    std::chrono::milliseconds discovery_time) {
  client.PollUntil([] { return false; }, discovery_time);
  const auto checked_until = std::chrono::steady_clock::now();
  std::optional<client::ServiceView> rival;
  const auto is_decided = [&] {
    rival = RivalOf(set, cells, client);
    return !rival || rival->reported_at > checked_until + kGoesOnTime;
  };
  client.PollUntil(is_decided, kLeaveTime);
  if (!rival) return {};
  return Fail(ErrorCode::kRefused,
              fmt::format("{} (process {} on {}) already runs: end that shop, or open "
                          "this one in another --domain or with another --tag",
                          rival->instance, rival->pid, rival->host));
}

/// A file for each time that the shop is open.
Result<fs::path> NewRecording(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Fail(ErrorCode::kIo, fmt::format("cannot make the folder {}: {}",
                                            folder.string(), error.message()));
  }
  std::string name = host::UtcText(std::chrono::system_clock::now());
  std::replace(name.begin(), name.end(), ':', '-');
  return folder / (name + ".mcap");
}

/// The shop's folder is of this process alone, and its queue is one of ours.
Status LockFolder(const client::ServiceSetOptions& set,
                  std::optional<client::FolderLock>& lock) {
  const bool has_queue = !set.without.contains("job-service");
  if (has_queue) INTAGLIO_TRY(history::CheckJobDatabase(set.folder / "jobs.db"));
  auto taken = INTAGLIO_TRY(client::FolderLock::Take(set.folder));
  lock.emplace(std::move(taken));
  // Now nobody writes it.
  return has_queue ? history::CheckQueue(set.folder / "jobs.db") : Status();
}

/// What the shop was opened with, to the job service. Of a real machine nothing is
/// reported that nobody has named; an identity that may not command says nothing.
Status ReportMounted(const UpOptions& options, client::JobClient& client,
                     const std::string& cell, const MountedParts& mounted) {
  const MountFlags& given = options.mount;
  const bool named = !given.block_mm.empty() || !given.glass.empty() ||
                     given.refractive_index > 0 || !given.lens.empty() ||
                     !given.piece.empty();
  if (options.real_machine && !named) return {};
  if (!client.may_command()) {
    std::cerr << "this identity may not say what is mounted: intaglio mount\n";
    return {};
  }
  const auto known = client.mounts().find(cell);
  const MountedParts parts = options.real_machine && known != client.mounts().end()
                                 ? MergedParts(known->second.parts, mounted)
                                 : mounted;
  return client.Mount(cell, parts, intaglio_ARM_BY_PROGRAM, 15s);
}

void Welcome(client::ShopCells& shop, const MountedParts& mounted,
             const MachineSpec& machine, const client::ServiceSetOptions& set) {
  for (const std::string& process : shop.Processes()) std::cout << process << "\n";
  std::cout << MountedText(mounted, machine) << "\n";
  for (const fs::path& file : shop.machine_files()) {
    std::cout << "machine profile for jobs: " << file.string() << "\n";
  }
  std::cout << "the shop is open (domain " << set.bus.control_domain << ", interface "
            << set.bus.interface
            << "); from another terminal: intaglio submit JOB --arm --watch\n"
               "Ctrl-C closes it\n"
            << std::flush;
}

/// Until Ctrl-C, or until a service has died for good. `proofs`: empty without a machine.
int KeepOpen(client::ShopCells& shop, client::JobClient& client,
             std::vector<client::ShopProofs>& proofs) {
  while (Interrupts() == 0) {
    client.Poll(200ms);
    TurnProofs(proofs, client);
    const auto revived = shop.Revive();
    if (!revived) {
      shop.Stop();
      return Complain(revived.error(), client::kExitMachine);
    }
    for (const std::string& sent : *revived) std::cerr << sent << "\n";
  }
  shop.Stop();
  FinishProofs(proofs, client);
  return client::kExitGood;
}

/// What the shop has, and what its further cells have.
Result<std::vector<client::ShopCells::Cell>> CellsOf(
    const UpOptions& options, const client::ServiceSetOptions& set,
    const std::vector<MachineSpec>& machines, const MountedParts& mounted) {
  std::vector<client::ShopCells::Cell> cells;
  for (const MachineSpec& machine : machines) {
    const bool is_first = cells.empty();
    cells.push_back({is_first ? set : client::OptionsOfCell(set, machine), {}});
    if (options.real_machine) continue;
    cells.back().virtual_machine = INTAGLIO_TRY(MachineOf(options, machine, mounted));
  }
  return cells;
}

/// Waits for all services, reports what is mounted, and opens the page.
std::optional<int> Open(const UpOptions& options, client::ShopCells& shop,
                        client::JobClient& client,
                        const std::vector<client::ShopCells::Cell>& cells,
                        const MountedParts& mounted) {
  if (auto ready = shop.AwaitReady(client); !ready) {
    shop.Stop();
    const bool faulty = ready.error().code == ErrorCode::kFault;
    return Complain(ready.error(), faulty ? client::kExitMachine : client::kExitInternal);
  }
  for (const client::ShopCells::Cell& cell : cells) {
    if (cell.options.without.contains("synchronizer")) continue;
    const Status reported =
        ReportMounted(options, client, cell.options.bus.cell, mounted);
    if (reported) continue;
    shop.Stop();
    return Complain(reported.error(), client::kExitMachine);
  }
  if (cells.front().options.console.port < 0) return std::nullopt;
  const auto address = shop.AwaitConsole();
  if (!address) {
    shop.Stop();
    return Complain(address.error(), client::kExitWrongInput);
  }
  std::cout << "web console: " << *address << "\n";
  return std::nullopt;
}

int Up(const UpOptions& options) {
  CatchInterrupts();
  const auto file = FindMachineFile(options.machine);
  if (!file) {
    return Complain(Prefixed(file.error(), "--machine: "), client::kExitWrongInput);
  }
  const auto machine = ReadMachineFile(*file);
  if (!machine) return Complain(machine.error(), client::kExitWrongInput);
  client::ServiceSetOptions set;
  set.folder = fs::absolute(options.folder);
  set.results = set.folder / "jobs";
  set.materials_db = materials_db::DatabasePathOf(options.materials_db);
  set.machine = client::WithKeptTaught(set.folder, *machine);
  set.bus = options.bus;
  set.bus.cell = machine->name();
  set.without = {options.without.begin(), options.without.end()};
  set.console = SettingOf(options.console);
  // What a refused shop has made goes again, while the folder is still locked.
  std::optional<client::FolderLock> lock;
  client::FreshPaths fresh(
      {set.folder, set.folder / "lock", set.folder / "recordings", set.materials_db});
  if (auto room = client::CheckRoom(set.folder); !room)
    return Complain(room.error(), client::kExitMachine);
  if (auto locked = LockFolder(set, lock); !locked)
    return Complain(locked.error(), client::kExitWrongInput);
  bus::Bus bus(set.bus);
  client::JobClient client(bus);
  const auto machines = client::CopiesOf(*machine, options.cells);
  std::set<std::string> names;
  for (const MachineSpec& one : machines) names.insert(one.name());
  if (auto alone = AwaitNoRival(set, names, client, bus.discovery_time()); !alone) {
    return Complain(alone.error(), client::kExitWrongInput);
  }
  const auto mounted =
      MountedOf(options.mount, !options.real_machine, *machine, set.materials_db);
  if (!mounted) return Complain(mounted.error(), client::kExitWrongInput);
  if (options.record) {
    const auto recording = NewRecording(set.folder / "recordings");
    if (!recording) return Complain(recording.error(), client::kExitWrongInput);
    set.recording = *recording;
    set.recording_bulk = options.bulk;
  }
  const auto cells = CellsOf(options, set, machines, *mounted);
  if (!cells) return Complain(cells.error(), client::kExitWrongInput);
  fresh.Keep();
  auto shop = client::ShopCells::Start(*cells);
  if (!shop) return Complain(shop.error(), client::kExitInternal);
  if (const auto failed = Open(options, *shop, client, *cells, *mounted)) return *failed;
  Welcome(*shop, *mounted, *machine, set);
  std::vector<client::ShopProofs> proofs;
  for (const client::ShopCells::Cell& cell : *cells) {
    if (cell.options.without.contains("synchronizer")) continue;
    proofs.push_back(
        ProofsOf(cell.options.folder, cell.options.bus.cell, options.picture));
  }
  return KeepOpen(*shop, client, proofs);
}

}  // namespace

void AddUpCommand(command_line::Command app) {
  auto options = std::make_shared<UpOptions>();
  command_line::Command up =
      app.AddCommand("up", "start the services of a shop and keep them running");
  AddBusFlags(up, options->bus);
  up.AddOption("--machine", options->machine, "machine profile: els-03, or a file")
      .ShowDefault();
  up.AddOption("--folder", options->folder, "queue, logs and job folders").ShowDefault();
  up.AddOption("--materials", options->materials_db, "material base, default the user's");
  up.AddOption("--without", options->without, "services that run elsewhere");
  const auto record = up.AddFlag("--record", options->record,
                                 "record all messages in the folder's recordings");
  AddBulkFlag(up, options->bulk).Need(record);
  AddConsoleFlags(up, options->console);
  const auto real =
      up.AddFlag("--real-machine", options->real_machine,
                 "no virtual engraver: the profile's serial devices are used");
  const auto is_virtual = up.AddFlag("--virtual", options->is_virtual,
                                     "a virtual engraver in the machine's place, as "
                                     "without --real-machine")
                              .Exclude(real);
  up.AddOption("--cells", options->cells,
               "so many machines: copies of the profile, named NAME, NAME-2, NAME-3 ...")
      .Within(1, 100)
      .Need(is_virtual)
      .ShowDefault();
  const auto lockstep =
      up.AddFlag("--lockstep", options->lockstep,
                 "the virtual machine runs as fast as the points arrive");
  up.AddOption("--speed", options->speed,
               "speed of the virtual machine as a multiple of real time")
      .Within(0.01, 1000.0)
      .Exclude(lockstep);
  AddTruthFlags(up, options->truth);
  AddMountFlags(up, options->mount);
  AddPictureStyleFlags(up, options->picture);
  up.SetFooter(
      "Example: intaglio up --folder shop --block 60 60 40, and from another terminal: "
      "intaglio submit job.textproto --arm --watch\n"
      "Example: intaglio up --cells 3 --virtual --folder shop, for jobs with "
      "--machine shop/cells/els-03-2/machine.textproto, too\n"
      "Ctrl-C closes the shop; the queue is kept in its folder.");
  up.SetAction([options] { return Up(*options); });
}

}  // namespace intaglio::cli
