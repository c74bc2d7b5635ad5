// `intaglio machine new`: a profile from that of a family.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/cli/machine/machine_command.h"
#include "services/cli/machine/machine_questions.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/checks/job_check.h"
#include "services/job/files/job_file.h"
#include "services/job/files/lightburn_profile.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct NewOptions {
  std::string family, out, name, from, device;
  std::vector<std::string> changes;
  bool ask = false, no_questions = false;
};

/// The comment at the head of a profile, its first sentence.
std::string PurposeOf(const fs::path& file) {
  std::ifstream in(file);
  std::string text, line;
  while (std::getline(in, line) && line.starts_with("# ")) {
    text += (text.empty() ? "" : " ") + line.substr(2);
    for (auto end = text.find(". "); end != std::string::npos;
         end = text.find(". ", end + 1)) {
      // Not that of an abbreviation: "ch. 8".
      if (end + 2 < text.size() && text[end + 2] >= 'A' && text[end + 2] <= 'Z')
        return text.substr(0, end);
    }
    if (text.ends_with('.')) return text.substr(0, text.size() - 1);
  }
  return text;
}

int PrintFamilies() {
  const fs::path folder =
      command_line::SuppliedFolder() / command_line::kSuppliedProfiles.folder;
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".textproto") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    std::cout << fmt::format("{:<16} {}\n", file.stem().string(), PurposeOf(file));
  }
  std::cerr
      << "intaglio machine new FAMILY --out FILE makes a profile from one of them\n";
  return client::kExitGood;
}

void PrintNotRead(const std::vector<DeviceSetting>& settings, const char* what) {
  if (settings.empty()) return;
  std::cerr << what << "\n";
  for (const DeviceSetting& setting : settings) {
    std::cerr << "    " << setting.key << " " << setting.value << "\n";
  }
}

/// The settings that another program has of the machine; prints what was read and what
/// was not.
Status Import(const NewOptions& options, MachineSpec& machine) {
  const std::string bytes =
      INTAGLIO_TRY(io::ReadWholeFile(options.from, kMaxLightBurnFileBytes));
  const LightBurnDevice device =
      INTAGLIO_TRY(ReadLightBurnDevice(bytes, options.from, options.device));
  const auto applied = ApplyDevice(device, machine);
  if (!applied) return tl::unexpected(io::AboutFile(applied.error(), options.from));
  std::cerr << fmt::format("{}: the device \"{}\"\n", options.from, device.name);
  for (const std::string& sentence : *applied) std::cerr << "  " << sentence << "\n";
  PrintNotRead(device.field_not_read,
               "  not read, though it moves the beam; make a correction file, and check "
               "the directions of x and y at the machine:");
  PrintNotRead(device.not_read,
               "  not read, since nothing public explains it or no profile has it; give "
               "the delays of your machine by --set or the questions:");
  return {};
}

Result<MachineSpec> MakeProfile(const NewOptions& options) {
  const fs::path file = INTAGLIO_TRY(
      command_line::FindSupplied(options.family, command_line::kSuppliedProfiles));
  MachineSpec machine = INTAGLIO_TRY(ReadUncheckedMachine(file));
  machine.set_name(options.name.empty() ? fs::path(options.out).stem().string()
                                        : options.name);
  if (!options.from.empty()) INTAGLIO_TRY(Import(options, machine));
  for (const std::string& change : options.changes) {
    INTAGLIO_TRY(ChangeField(machine, change));
  }
  if (options.ask || (!options.no_questions && isatty(STDIN_FILENO) != 0)) {
    std::cerr << "An empty line keeps the value in brackets.\n";
    AskAboutMachine(std::cin, std::cerr, machine);
  }
  if (const auto errors = CheckMachine(machine); !errors.empty()) {
    return tl::unexpected(JoinErrors(errors));
  }
  return machine;
}

int New(const NewOptions& options) {
  if (options.family.empty() && options.from.empty()) return PrintFamilies();
  if (options.family.empty()) {
    return Complain({ErrorCode::kMissing,
                     "--from: needs the family of the machine as well: bjjcz (marks) or "
                     "bjjcz-glass (points in glass)",
                     options.from});
  }
  if (options.from.empty() && !options.device.empty()) {
    return Complain({ErrorCode::kMissing,
                     "--device: names a device in the file of --from; give it, too",
                     options.device});
  }
  if (options.out.empty()) {
    return Complain({ErrorCode::kMissing,
                     "--out: is missing; name the file of the new profile, e.g. "
                     "--out shop-1.textproto",
                     ""});
  }
  if (fs::exists(options.out)) {
    return Complain(
        {ErrorCode::kInvalidValue,
         "--out: " + options.out + " exists already; name another file, or remove it",
         options.out});
  }
  const auto machine = MakeProfile(options);
  if (!machine) return Complain(machine.error());
  if (const Status written = WriteMachineFile(options.out, *machine); !written) {
    return Complain(written.error());
  }
  std::cout << options.out << "\n";
  std::cerr << "Every field, and how it is measured: docs/machines/profile.md. Next: "
               "intaglio machine check "
            << options.out << "\n";
  return client::kExitGood;
}

}  // namespace

void AddMachineNewCommand(command_line::Command machine) {
  auto options = std::make_shared<NewOptions>();
  command_line::Command create =
      machine.AddCommand("new", "make a profile from that of a family");
  create.AddOption("FAMILY", options->family,
                   "a supplied profile, or a file; without it the families are listed");
  create.AddOption("--out", options->out, "the new profile, .textproto or .json");
  create.AddOption("--name", options->name,
                   "name of the machine; default that of the file");
  create.AddOption("--from", options->from,
                   "settings of the machine from LightBurn: a device that it exported, "
                   ".lbdev or .lbzip");
  create.AddOption("--device", options->device,
                   "the device of --from, where it has several");
  create.AddOption("--set", options->changes,
                   "fields that differ, field=value, e.g. x.travel_max_mm=300");
  const auto ask = create.AddFlag("--ask", options->ask,
                                  "asks for what differs; the default at a terminal");
  create.AddFlag("--no-questions", options->no_questions, "asks nothing").Exclude(ask);
  create.SetFooter(
      "Example: intaglio machine new els-03 --out shop-1.textproto --set "
      "x.travel_max_mm=300 laser.channels=1\n"
      "Exit code: 0 made, 2 wrong input; then every mistake is printed, and no file is "
      "made.");
  create.SetAction([options] { return New(*options); });
}

}  // namespace intaglio::cli
