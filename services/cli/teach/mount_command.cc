#include "services/cli/teach/mount_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <ostream>

#include "engrave/core/try.h"
#include "materials_db/material_store.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/job/job_options.h"
#include "services/cli/job/job_series.h"
#include "services/cli/teach/mounted.h"
#include "services/cli/teach/teach_options.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/files/job_file.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct MountOptions : TeachOptions {
  std::string machine = "els-03";
  std::string materials_db;
  MountFlags parts;
};

bool IsNamed(const MountFlags& flags) {
  return !flags.block_mm.empty() || !flags.glass.empty() || flags.refractive_index > 0 ||
         !flags.lens.empty() || !flags.piece.empty() || flags.wavelength_nm > 0;
}

/// Waits for the job service, and for what it has published of the machines.
Status Connect(client::JobClient& client, bus::Bus& bus, const std::string& cell) {
  const auto served = [&] {
    for (const client::ServiceView& service : client.services()) {
      if (service.role == intaglio_ROLE_JOB_SERVICE) return true;
    }
    return false;
  };
  if (!client.PollUntil(served, bus.discovery_time()))
    return Fail(ErrorCode::kTimedOut, client::kNoJobService);
  client.PollUntil([&] { return client.mounts().contains(cell); }, 300ms);
  return {};
}

int ShowMounted(client::JobClient& client, const std::string& cell) {
  const auto mount = client.mounts().find(cell);
  if (mount == client.mounts().end()) {
    std::string others;
    for (const auto& [name, other] : client.mounts())
      others += (others.empty() ? "" : ", ") + name;
    std::cout << cell << ": nobody has reported what is mounted"
              << (others.empty()
                      ? "; say it with --block, --glass and --lens, or with --piece\n"
                      : "; it is known of " + others + ": name its profile, --machine\n");
  } else {
    std::cout << MountText(cell, mount->second) << "\n";
  }
  return client::kExitGood;
}

/// `machine`: the profile; `cell`: its name, or that of a machine without a profile here.
int Mount(const MountOptions& options, const std::string& cell,
          const Result<MachineSpec>& machine) {
  MountedParts named;
  if (machine) {
    const fs::path materials = materials_db::DatabasePathOf(options.materials_db);
    auto mounted = NamedParts(options.parts, *machine, materials);
    if (!mounted) return Complain(mounted.error());
    named = std::move(*mounted);
  } else if (IsNamed(options.parts)) {
    // A block, an index and a piece are said without a profile.
    if (!options.parts.lens.empty() || !options.parts.glass.empty() ||
        options.parts.wavelength_nm > 0)
      return Complain(machine.error());
    named = NamedParts(options.parts, MachineSpec(), {}).value();
  }
  bus::Bus bus(WithoutCells(options.bus));
  client::JobClient client(bus);
  if (auto connected = Connect(client, bus, cell); !connected)
    return Complain(connected.error());
  if (!IsNamed(options.parts)) return ShowMounted(client, cell);
  const auto known = client.mounts().find(cell);
  const MountedParts parts = MergedParts(
      known == client.mounts().end() ? MountedParts() : known->second.parts, named);
  if (auto taken = client.Mount(cell, parts, intaglio_ARM_BY_PERSON); !taken)
    return Complain(taken.error(), client::kExitMachine);
  std::cout << cell << ": " << TextOf(parts) << "\n";
  return client::kExitGood;
}

/// At a machine of the shop, whose own profile counts where it is on this computer.
int MountAtCell(const MountOptions& options) {
  std::string cell, profile;
  const int found = WithMachine(options, [&](client::TeachClient& client) {
    cell = client.view().cell;
    profile = client.view().profile;
    return static_cast<int>(client::kExitGood);
  });
  if (found != client::kExitGood) return found;
  return Mount(options, cell, ReadMachineFile(profile));
}

void AddParts(command_line::Command command, MountOptions& options) {
  AddNamedMountFlags(command, options.parts);
  command.AddOption("--materials", options.materials_db,
                    "material base, default the user's");
}

}  // namespace

MountedParts MergedParts(MountedParts known, const MountedParts& named) {
  if (named.block_mm) known.block_mm = named.block_mm;
  if (named.refractive_index) {
    known.refractive_index = named.refractive_index;
    known.glass = named.glass;
  }
  if (named.lens) {
    known.lens = named.lens;
    known.lens_name = named.lens_name;
  }
  if (!named.piece.empty()) known.piece = named.piece;
  return known;
}

std::string MountText(const std::string& cell, const client::MountView& mount) {
  return fmt::format("{:<10} {} ({}, {})", cell, TextOf(mount.parts), mount.operator_name,
                     mount.mounted_utc);
}

void PrintMounted(client::JobClient& client, const std::string& cell, std::ostream& out) {
  client.PollUntil([&] { return client.mounts().contains(cell); }, 200ms);
  const auto mount = client.mounts().find(cell);
  if (mount == client.mounts().end()) return;
  const std::string text = TextOf(mount->second.parts);
  if (!text.empty()) out << text << ": armed\n";
}

void AddMountCommand(command_line::Command app) {
  auto options = std::make_shared<MountOptions>();
  command_line::Command command = app.AddCommand(
      "mount", "say what is mounted in a machine; it ends every arm there");
  command
      .AddOption("--machine", options->machine,
                 "machine profile, by name or file, or a machine of the shop by its name")
      .ShowDefault();
  AddParts(command, *options);
  AddBusFlags(command, options->bus);
  command.SetFooter(
      "Example: intaglio mount --machine els-03 --block 60 30 20 --glass N-BK7 --lens "
      "f70\n"
      "What is not named stays as it was reported before; without parts it prints what "
      "is "
      "known.");
  command.SetAction([options] {
    const auto file = FindMachineFile(options->machine);
    if (!file && options->machine.find_first_of("/.") == std::string::npos) {
      options->cell = options->machine;
      return MountAtCell(*options);
    }
    if (!file) return Complain(Prefixed(file.error(), "--machine: "));
    const auto machine = ReadMachineFile(*file);
    if (!machine) return Complain(machine.error());
    return Mount(*options, machine->name(), machine);
  });
}

void AddTeachMount(command_line::Command teach) {
  auto options = std::make_shared<MountOptions>();
  command_line::Command command = teach.AddCommand(
      "mount", "say what is mounted in the machine; it ends every arm there");
  AddTeachFlags(command, *options);
  AddParts(command, *options);
  command.SetFooter(
      "Example: intaglio teach mount --block 60 30 20 --glass N-BK7 --lens f70");
  command.SetAction([options] { return MountAtCell(*options); });
}

}  // namespace intaglio::cli
