// `intaglio galvo grid`: the job of the grid by which the field of a scan head is
// measured.

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "services/cli/galvo/galvo_command.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/machine/grid_job.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

struct GridOptions {
  std::string machine, out;
  client::GridJob job;
};

int WriteGrid(const GridOptions& options) {
  client::GridJob job = options.job;
  const auto machine =
      command_line::FindSupplied(options.machine, command_line::kSuppliedProfiles);
  if (!machine) return Complain(machine.error(), client::kExitWrongInput);
  job.machine_file = *machine;
  const auto grid = client::WriteGridJob(job, options.out);
  if (!grid) return Complain(grid.error(), client::kExitWrongInput);
  std::cout << grid->job_file.string() << "\n";
  std::cerr << fmt::format(
      "{} x {} discs of {:.6g} um, {:.6g} mm apart, and one right of the middle and "
      "above "
      "it, which shows how a picture is turned. They are marked {}.\n"
      "Mark them: intaglio submit {} --arm --watch. Then scan the piece: intaglio galvo "
      "calibrate SCAN --machine {} --nodes {} --pitch {:.6g} --mark-size {:.6g} --pixel "
      "UM --out new.ct5; or measure the discs, write their places into {}, and give it "
      "in "
      "place of the scan: intaglio galvo calibrate FILE --machine {} --out new.ct5\n",
      job.nodes, job.nodes, job.mark_um, grid->pitch_mm,
      grid->correction_file.empty() ? "without a correction"
                                    : "with the correction " + grid->correction_file,
      grid->job_file.string(), options.machine, job.nodes, grid->pitch_mm, job.mark_um,
      (std::filesystem::path(options.out) / "grid.csv").string(), options.machine);
  return client::kExitGood;
}

}  // namespace

void AddGalvoGridCommand(command_line::Command galvo) {
  auto o = std::make_shared<GridOptions>();
  command_line::Command grid =
      galvo.AddCommand("grid", "the job of the grid by which a field is measured");
  grid.AddOption(
          "--machine", o->machine,
          "profile of the scan head, a file or a supplied name; the grid is marked "
          "with its correction_file, or with none")
      .Require();
  grid.AddOption("--nodes", o->job.nodes, "discs a side, odd")
      .Within(5, 65)
      .ShowDefault();
  grid.AddOption("--pitch", o->job.pitch_mm,
                 "mm between discs; default: they cover 96 % of the field")
      .Positive();
  grid.AddOption("--mark-size", o->job.mark_um, "diameter of a disc, um")
      .Positive()
      .ShowDefault();
  grid.AddOption("--out", o->out,
                 "folder of the job grid.textproto, of its drawing, and of grid.csv for "
                 "measured places")
      .Require();
  grid.SetFooter(
      "Example: intaglio galvo grid --machine galvo --out grid; "
      "intaglio submit grid/grid.textproto --arm --watch\n"
      "Exit code: 0 good, 2 wrong input.");
  grid.SetAction([o] { return WriteGrid(*o); });
}

}  // namespace intaglio::cli
