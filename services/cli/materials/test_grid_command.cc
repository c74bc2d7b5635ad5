#include "services/cli/materials/test_grid_command.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "services/cli/job/job_series.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/machine/test_grid.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct TestGridOptions {
  client::TestGrid grid;
  std::string machine = "els-03", out = "intaglio-test-grid";
  std::string materials_db;
  std::vector<double> block_mm;
};

/// A grid that no machine makes is refused here, and not left behind: a person would
/// engrave it in the shop.
Status CheckGrid(const fs::path& file, const std::string& materials_db) {
  const auto materials = INTAGLIO_TRY(
      materials_db::MaterialStore::Open(materials_db::DatabasePathOf(materials_db)));
  JobFlags flags;
  flags.job_file = file.string();
  INTAGLIO_TRY(CheckedAsInShop(BuildJob(flags), materials));
  return {};
}

int MakeTestGrid(const TestGridOptions& options) {
  const auto machine =
      command_line::FindSupplied(options.machine, command_line::kSuppliedProfiles);
  if (!machine) return Complain(machine.error());
  client::TestGrid grid = options.grid;
  grid.machine_file = *machine;
  if (!options.block_mm.empty())
    grid.block_mm = Eigen::Map<const Vec3>(options.block_mm.data());
  const auto made = client::WriteTestGrid(grid, options.out);
  if (!made) return Complain(made.error());
  for (const fs::path& file : *made) {
    if (const auto good = CheckGrid(file, options.materials_db); !good) {
      std::error_code ignored;
      for (const fs::path& written : *made) fs::remove(written, ignored);
      return Complain(good.error());
    }
  }
  for (const fs::path& file : *made) std::cout << file.string() << "\n";
  std::cerr << "See it: intaglio preview " << made->front().string()
            << ". Engrave it: intaglio submit " << made->front().string()
            << " --arm --watch (or intaglio run, in the virtual engraver)"
            << (made->size() > 1 ? ", then the others into the same block" : "")
            << ". Then choose energy and "
            << (options.grid.pulses.empty() ? "spacing" : "pulses")
            << " of your jobs by its look.\n";
  return client::kExitGood;
}

}  // namespace

void AddTestGridCommand(command_line::Command app) {
  auto options = std::make_shared<TestGridOptions>();
  command_line::Command command = app.AddCommand(
      "test-grid",
      "make the job of a material test: patches by pulse energy and spacing, labelled");
  command.AddOption("--energies", options->grid.energies_mj,
                    "pulse energies before a splitter, mJ, one row each; default four "
                    "up to the machine's largest");
  command.AddOption("--spacings", options->grid.spacings_mm,
                    "distances of the points, mm, one column each; default 1, 1.25, 1.5 "
                    "and 2 diameters of a crack");
  command
      .AddOption("--pulses", options->grid.pulses,
                 "pulses of a point, one column and one job each, in place of "
                 "spacings: of a head that jumps and dwells")
      .Within(1, 10000);
  command.AddOption("--patch", options->grid.patch_mm, "side of a patch, mm")
      .ShowDefault();
  command.AddOption("--glass", options->grid.glass, "glass of the block, or n=INDEX")
      .ShowDefault();
  command
      .AddOption("--block", options->block_mm,
                 "size of the block, mm, default as large as the grid needs")
      .TakeValues(3)
      .Positive();
  command.AddOption("--machine", options->machine, "machine profile: a name, or a file")
      .ShowDefault();
  command.AddOption("--out", options->out, "folder of the job file").ShowDefault();
  command.AddOption("--materials", options->materials_db,
                    "material base, default the user's");
  command.SetFooter(
      "Example: intaglio test-grid --glass K9 --energies 10 20 30 --spacings 0.1 0.15");
  command.SetAction([options] { return MakeTestGrid(*options); });
}

}  // namespace intaglio::cli
