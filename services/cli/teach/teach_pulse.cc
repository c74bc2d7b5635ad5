#include "services/cli/teach/teach_pulse.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

#include "services/cli/teach/teach_options.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/teach/stage_per_glass.h"
#include "services/client/teach/test_job.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using client::TeachClient;
using client::TeachOrder;

struct PulseOptions : TeachOptions {
  std::vector<double> block_mm;
  client::TestJob job;
  std::string machine, materials_db, out;
  std::optional<double> energy_mj, wavelength_nm;
  FocusSeries series;
  std::uint32_t first = 0;  ///< 0: a series is made
};

void AddPulseFlags(command_line::Command command, PulseOptions& options) {
  AddTeachFlags(command, options);
  command.AddOption("--block", options.block_mm, "size of the block, mm")
      .TakeValues(3)
      .Positive();
  command.AddOption("--glass", options.job.glass, "its glass").ShowDefault();
  command.AddOption("--lens", options.job.lens,
                    "name of the mounted lens; default the profile's");
  command.AddOption("--channel", options.job.channel, "channel")
      .Within(1, 4)
      .ShowDefault();
  command
      .AddOption("--energy", options.energy_mj,
                 "mJ of a pulse; default a tenth of the laser's")
      .Positive();
  command
      .AddOption("--wavelength", options.wavelength_nm,
                 "nm, to which the laser is set, one of a profile with several; default "
                 "the profile's laser.wavelength_nm")
      .Within(200.0, 2000.0);
  command.AddOption("--machine", options.machine,
                    "profile; default that of the machine that is found, on its "
                    "computer");
  command.AddOption("--materials", options.materials_db, "material base");
  command.AddOption("--out", options.out, "folder of the job").ShowDefault();
}

/// Where the axes are, and the profile.
int TakePlace(PulseOptions& options) {
  return WithMachine(options, [&](TeachClient& client) -> int {
    if (!client.view().homed) {
      return Complain({ErrorCode::kRefused,
                       "the controller does not know where its axes are: home it first "
                       "(intaglio teach home)",
                       ""},
                      client::kExitMachine);
    }
    options.job.axes = client.view().position;
    options.job.machine_file =
        fs::absolute(options.machine.empty() ? client.view().profile : options.machine);
    return client::kExitGood;
  });
}

int SubmitTest(PulseOptions& options, bool series, const SubmitFile& submit) {
  if (options.block_mm.size() != 3) {
    return Complain(
        {ErrorCode::kMissing, "--block: is missing; give the block's size in mm", ""});
  }
  if (const int taken = TakePlace(options); taken != client::kExitGood) return taken;
  options.job.block_mm = Eigen::Map<const Vec3>(options.block_mm.data());
  options.job.energy_mj = options.energy_mj;
  options.job.wavelength_nm = options.wavelength_nm;
  const auto ratio = client::StagePerGlassOf(options.materials_db);
  const auto file =
      series ? client::WriteFocusSeries(options.job, ratio, options.series, options.out)
             : client::WriteTestPulse(options.job, ratio, options.out);
  if (!file) return Complain(file.error());
  const int submitted = submit(options.bus, file->string());
  if (series && submitted == client::kExitGood) {
    std::cout << "count the points without a crack from the start of the row, then: "
                 "intaglio teach focus --out "
              << options.out << " --first NUMBER\n";
  }
  return submitted;
}

int TeachFirstCrack(const PulseOptions& options) {
  const auto move = client::ZeroMoveOfSeries(
      options.out, options.first, client::StagePerGlassOf(options.materials_db));
  if (!move) return Complain(move.error());
  return WithMachine(options, [&](TeachClient& client) {
    TeachOrder order;
    order.kind = intaglio_TEACH_ZERO_MOVED;
    order.place = Vec3(0, 0, move->z_mm);
    order.channel = move->channel;
    order.lens = move->lens;
    order.sets = 4;
    return ExecuteOrder(client, order);
  });
}

void AddPulse(command_line::Command teach, const SubmitFile& submit) {
  auto options = std::make_shared<PulseOptions>();
  options->out = "teach-pulse";
  command_line::Command command = teach.AddCommand(
      "pulse", "submit a job of one weak pulse at the present place; arm it to fire");
  AddPulseFlags(command, *options);
  command.SetFooter("Example: intaglio teach pulse --block 50 50 30 --energy 2");
  command.SetAction([options, submit] { return SubmitTest(*options, false, submit); });
}

void AddFocus(command_line::Command teach, const SubmitFile& submit) {
  auto options = std::make_shared<PulseOptions>();
  options->out = "teach-focus";
  command_line::Command command = teach.AddCommand(
      "focus",
      "submit a row of points at growing depth, or teach the zero in z by its first "
      "crack");
  AddPulseFlags(command, *options);
  command.AddOption("--step", options->series.step_mm, "mm of depth between two points")
      .Within(0.001, 10.0)
      .ShowDefault();
  command.AddOption("--count", options->series.count, "points")
      .Within(2, 1000)
      .ShowDefault();
  command.AddOption("--pitch", options->series.pitch_mm, "mm between two points along x")
      .Within(0.05, 10.0)
      .ShowDefault();
  command.AddOption("--first", options->first,
                    "number of the first point with a visible crack, from 1: teaches "
                    "the zero by the series in --out");
  command.SetFooter(
      "Example: intaglio teach focus --block 50 50 30   a row, which a person arms\n"
      "  intaglio teach focus --first 12               its first crack is point 12");
  command.SetAction([options, submit] {
    return options->first > 0 ? TeachFirstCrack(*options)
                              : SubmitTest(*options, true, submit);
  });
}

}  // namespace

void AddTestPulseCommands(command_line::Command teach, const SubmitFile& submit) {
  AddPulse(teach, submit);
  AddFocus(teach, submit);
}

}  // namespace intaglio::cli
