// `intaglio machine check`: everything that is wrong with a profile, at once.

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "engrave/post/point_program.h"
#include "services/cli/complain.h"
#include "services/cli/machine/machine_command.h"
#include "services/client/exit_codes.h"
#include "services/client/machine/device_comparison.h"
#include "services/job/job_check.h"
#include "services/job/job_defaults.h"
#include "services/job/job_file.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct CheckOptions {
  std::string profile;
  bool offline = false;
};

/// The profile's template, if it names one.
Status CheckPost(const MachineSpec& machine) {
  if (machine.post().empty()) return {};
  const fs::path file = INTAGLIO_TRY(
      command_line::FindSupplied(machine.post(), command_line::kSuppliedTemplates));
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, 1 << 20));
  INTAGLIO_TRY(post::ParsePointTemplate(text, file.string()));
  return {};
}

std::vector<Error> FindAll(const MachineSpec& machine) {
  std::vector<Error> found = CheckMachine(machine);
  if (const Status post = CheckPost(machine); !post) {
    Error error = post.error();
    error.message = "post: " + error.message;
    found.push_back(std::move(error));
  }
  return found;
}

/// How many differences were printed.
int PrintDevices(const MachineSpec& machine) {
  int count = 0;
  for (const auto& line : client::CompareDevices(machine, link::MonotonicClock())) {
    if (!line.not_compared.empty()) {
      std::cout << line.line << ": not compared with the device: " << line.not_compared
                << "\n";
    } else if (line.differences.empty()) {
      std::cout << line.line << ": the device agrees with the profile\n";
    }
    for (const Error& difference : line.differences) {
      std::cout << difference.message << "\n";
      ++count;
    }
  }
  return count;
}

int Check(const CheckOptions& options) {
  const auto file =
      command_line::FindSupplied(options.profile, command_line::kSuppliedProfiles);
  if (!file) return Complain(file.error());
  const auto machine = ReadUncheckedMachine(*file);
  if (!machine) return Complain(machine.error());
  const std::vector<Error> found = FindAll(*machine);
  for (const Error& error : found) std::cout << error.message << "\n";
  int count = static_cast<int>(found.size());
  if (found.empty() && !options.offline) {
    count += PrintDevices(WithMachineDefaults(*machine));
  }
  if (count == 0) {
    std::cout << machine->name() << ": good, " << file->string() << "\n";
    return client::kExitGood;
  }
  std::cout << fmt::format("{}: {} to correct; every field: docs/machines/profile.md\n",
                           file->string(), count);
  return client::kExitWrongInput;
}

}  // namespace

void AddMachineCheckCommand(command_line::Command machine) {
  auto options = std::make_shared<CheckOptions>();
  command_line::Command check =
      machine.AddCommand("check", "everything that is wrong with a profile, at once");
  check
      .AddOption("PROFILE", options->profile,
                 "profile: a file, or the name of a supplied one")
      .Require();
  check.AddFlag("--offline", options->offline,
                "does not open the lines to compare with the devices");
  check.SetFooter(
      "A good profile is also compared with what the devices on its lines report: serial "
      "numbers, rates, channels, travel, tolerance. A line that another program uses is "
      "left alone.\n"
      "Example: intaglio machine check els-03\n"
      "Exit code: 0 good, 2 something has to be corrected.");
  check.SetAction([options] { return Check(*options); });
}

}  // namespace intaglio::cli
