// `intaglio machine check`: everything that is wrong with a profile, at once.

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "engrave/post/point_program.h"
#include "proto/machine_report.pb.h"
#include "services/cli/json/print_json.h"
#include "services/cli/machine/machine_command.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/machine/device_comparison.h"
#include "services/job/checks/arm_check.h"
#include "services/job/checks/head_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/head_warnings.h"
#include "services/job/machine/machine_defaults.h"
#include "services/job/quality/oblique_beams.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct CheckOptions {
  std::string profile;
  bool offline = false, json = false;
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

ProfileFinding FindingOf(const Error& error) {
  ProfileFinding finding;
  finding.set_field(error.message.substr(0, error.message.find(": ")));
  finding.set_message(error.message);
  return finding;
}

void FindAll(const MachineSpec& machine, MachineCheck& check) {
  std::vector<Error> found = CheckMachine(machine);
  if (const Status post = CheckPost(machine); !post) {
    Error error = post.error();
    error.message = "post: " + error.message;
    found.push_back(std::move(error));
  }
  for (Error& error : client::CheckDriversOf(machine)) found.push_back(std::move(error));
  for (const Error& error : found) *check.add_findings() = FindingOf(error);
  if (!found.empty()) return;
  for (const Error& error : HeadWarningsOf(machine))
    *check.add_warnings() = FindingOf(error);
  for (const Error& error : LensWarningsOf(machine))
    *check.add_warnings() = FindingOf(error);
  for (std::string& note : ObliqueNotesOf(WithMachineDefaults(machine)))
    check.add_notes(std::move(note));
  for (std::string& note : ArmNotesOf(machine)) check.add_notes(std::move(note));
}

void CompareDevices(const MachineSpec& machine, MachineCheck& check) {
  for (const auto& compared : client::CompareDevices(machine, link::MonotonicClock())) {
    CheckedLine& line = *check.add_lines();
    line.set_line(compared.line);
    line.set_not_compared(compared.not_compared);
    for (const Error& error : compared.differences)
      *line.add_differences() = FindingOf(error);
  }
}

int CountOf(const MachineCheck& check) {
  int count = check.findings_size();
  for (const CheckedLine& line : check.lines()) count += line.differences_size();
  return count;
}

void PrintText(const MachineCheck& check) {
  for (const ProfileFinding& finding : check.findings())
    std::cout << finding.message() << "\n";
  for (const ProfileFinding& warning : check.warnings())
    std::cout << "warning: " << warning.message() << "\n";
  for (const std::string& note : check.notes()) std::cout << "note: " << note << "\n";
  for (const CheckedLine& line : check.lines()) {
    if (!line.not_compared().empty()) {
      std::cout << line.line()
                << ": not compared with the device: " << line.not_compared() << "\n";
    } else if (line.differences().empty()) {
      std::cout << line.line() << ": the device agrees with the profile\n";
    }
    for (const ProfileFinding& difference : line.differences())
      std::cout << difference.message() << "\n";
  }
  if (check.good()) {
    std::cout << check.machine() << ": good, " << check.profile() << "\n";
  } else {
    std::cout << fmt::format("{}: {} to correct; every field: docs/machines/profile.md\n",
                             check.profile(), CountOf(check));
  }
}

int Check(const CheckOptions& options) {
  const auto file =
      command_line::FindSupplied(options.profile, command_line::kSuppliedProfiles);
  if (!file) return Complain(file.error());
  const auto machine = ReadUncheckedMachine(*file);
  if (!machine) return Complain(machine.error());
  MachineCheck check;
  check.set_machine(machine->name());
  check.set_profile(file->string());
  FindAll(*machine, check);
  if (check.findings().empty() && !options.offline)
    CompareDevices(WithMachineDefaults(*machine), check);
  check.set_good(CountOf(check) == 0);
  if (options.json) {
    if (const int failed = PrintJson(check); failed != client::kExitGood) return failed;
  } else {
    PrintText(check);
  }
  return check.good() ? client::kExitGood : client::kExitWrongInput;
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
  check.AddFlag("--json", options->json, "prints the findings as JSON");
  check.SetFooter(
      "A good profile is also compared with what the devices on its lines report: serial "
      "numbers, rates, channels, travel, tolerance; the settings of a grbl; the limits "
      "of "
      "LinuxCNC's HAL. A line that another program uses is left alone.\n"
      "Example: intaglio machine check els-03\n"
      "Exit code: 0 good, 2 something has to be corrected.");
  check.SetAction([options] { return Check(*options); });
}

}  // namespace intaglio::cli
