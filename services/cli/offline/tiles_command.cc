#include "services/cli/offline/tiles_command.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file_kinds.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/offline/offline_steps.h"
#include "services/cli/offline/path_job.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/machine/tile_jobs.h"
#include "services/job/models/read_limits.h"

namespace intaglio::cli {
namespace {

// A probe that fits under any head, to learn how large a part of the block lies under it.
constexpr double kProbeMm = 5;

struct TilesOptions {
  JobFlags job;
  std::string cloud, out, materials_db;
  double strip_mm = sort::BlockTileOptions().strip_mm;
};

/// The job of the part under the head, as high as the block.
Result<FrozenJob> BuildPartJob(const TilesOptions& options, const PointList& points_mm) {
  JobFlags flags = options.job;
  flags.block_mm = {kProbeMm, kProbeMm, kProbeMm};
  flags.margin_mm = 0;
  const auto probe = INTAGLIO_TRY(BuildJobOfPoints(flags, points_mm));
  const Vec2 part_mm = INTAGLIO_TRY(client::PartUnderHead(probe.machine, probe.job));
  flags.margin_mm = options.job.margin_mm;
  flags.block_mm = {part_mm.x(), part_mm.y(), options.job.block_mm[2]};
  return BuildPathJob(flags, points_mm, options.materials_db);
}

Status RequireInside(const TilesOptions& options, const PointList& points_mm) {
  const Vec3 block_mm = Eigen::Map<const Vec3>(options.job.block_mm.data());
  for (const Vec3& p : points_mm) {
    if ((p.array() >= 0).all() && (p.array() <= block_mm.array()).all()) continue;
    const std::string place = fmt::format("({:g}, {:g}, {:g})", p.x(), p.y(), p.z());
    return Fail(
        ErrorCode::kOutsideBlock,
        fmt::format("--cloud: the point at {} mm is outside the block of {:g} x "
                    "{:g} x {:g} mm; give the --block that the cloud was made for",
                    place, block_mm.x(), block_mm.y(), block_mm.z()),
        place);
  }
  return {};
}

Result<std::string> MakeTiles(const TilesOptions& options) {
  const ReadLimits limits = ReadLimitsTimes(options.job.size_limits);
  auto table = ReadPoints(options.cloud, limits.points);
  if (!table) {
    Error error = WithRemedy(table.error(), limits);
    error.message = "--cloud: " + error.message;
    return tl::unexpected(std::move(error));
  }
  INTAGLIO_TRY(RequireInside(options, table->points_mm));
  const FrozenJob job = INTAGLIO_TRY(BuildPartJob(options, table->points_mm));
  const auto tiling =
      INTAGLIO_TRY(client::ChooseTiles(job, table->points_mm, options.strip_mm));
  const Vec3 block_mm = Eigen::Map<const Vec3>(options.job.block_mm.data());
  INTAGLIO_TRY(
      client::WriteTileJobs(job, table->points_mm, tiling, block_mm, options.out));
  double way_mm = 0;
  for (std::size_t i = 1; i < tiling.tiles.size(); ++i) {
    way_mm += (tiling.tiles[i].axis_mm - tiling.tiles[i - 1].axis_mm).norm();
  }
  const bool on_stage = job.machine().head_over_block().has_block_stage();
  return fmt::format(
      "tiles       {} x {}, {} with points\nmoves       {}, {:.1f} mm, {}\n"
      "points      {}\njobs        {}/tiles.csv\n",
      tiling.columns, tiling.rows, client::GroupedDigits(tiling.tiles.size()),
      tiling.tiles.size() - 1, way_mm,
      on_stage ? "by the stage of each job" : "by you between the jobs",
      client::GroupedDigits(table->points_mm.size()), options.out);
}

int Tiles(const TilesOptions& options) {
  const auto text = MakeTiles(options);
  if (!text) return Complain(text.error());
  std::cout << *text;
  return client::kExitGood;
}

}  // namespace

void AddTilesCommand(command_line::Command app) {
  auto options = std::make_shared<TilesOptions>();
  command_line::Command tiles = app.AddCommand(
      "tiles", "jobs of a cloud that is wider than the field of a scan head, one a tile");
  tiles.AddOption("--cloud", options->cloud, "points: " + formats::PointExtensions())
      .Require();
  tiles.AddOption("--block", options->job.block_mm, "size of the whole block x y z, mm")
      .TakeValues(3)
      .Positive()
      .Require();
  tiles.AddOption("--out", options->out, "folder of the jobs").Require();
  tiles
      .AddOption("--strip", options->strip_mm,
                 "how far from a seam its two tiles are mixed, mm: more than the stage "
                 "misses")
      .ShowDefault();
  tiles.AddOption("--materials", options->materials_db,
                  "material base, default the user's");
  AddMarginFlag(tiles, options->job);
  AddSpacingFlag(tiles, options->job);
  AddOrderFlags(tiles, options->job);
  AddMotionFlags(tiles, options->job);
  AddMachineFlags(tiles, options->job);
  AddSetFlag(tiles, options->job);
  AddSizeLimitsFlag(tiles, options->job.size_limits);
  tiles.SetFooter(
      "Make the jobs in the order of tiles.csv. A machine with "
      "head_over_block.block_stage moves the block to each tile; else move it before "
      "each "
      "job by its move_x_mm and move_y_mm.\n"
      "Example: intaglio tiles --cloud cloud.ply --block 150 100 80 --machine "
      "galvo-glass "
      "--glass N-BK7 --out tiles");
  tiles.SetAction([options] { return Tiles(*options); });
}

}  // namespace intaglio::cli
