#include "services/client/machine/tile_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "engrave/core/try.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/io/atomic_file.h"
#include "services/job/beams/energy_by_place.h"
#include "services/job/beams/job_beams.h"
#include "services/job/checks/block_place_check.h"
#include "services/job/convert/options.h"
#include "services/job/fields/shapes.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxSide = 200;
// Divisions that are tried: below a telecentric lens the seams are oblique, and the first
// ones reach beyond.
constexpr int kMaxTries = 40;

/// Where a tile may have points, from the axis of the lens.
class UsableField {
 public:
  UsableField(const FrozenJob& job, double max_depth_mm)
      : height_mm_(BlockSizeOf(job.job()).z()) {
    const double energy_mj = WhyOneEnergy(job).empty()
                                 ? SettableEnergies(job.machine()).max_mj
                                 : job.job().laser().pulse_energy_mj();
    const Vec2 part_mm = BlockSizeOf(job.job()).head<2>();
    half_mm_ = 0.5 * part_mm - Vec2::Constant(job.job().block().margin_mm());
    const JobBeams beams(job);
    for (int depth_mm = 0; depth_mm <= std::ceil(max_depth_mm) + 1; ++depth_mm) {
      radii_mm_.push_back(beams.strength().UsableRadiusMm(depth_mm, energy_mj));
    }
  }

  bool Has(const Vec2& from_axis_mm, double z_mm) const {
    const double depth_mm = std::max(0.0, height_mm_ - z_mm);
    const auto below =
        std::min(static_cast<std::size_t>(std::ceil(depth_mm)), radii_mm_.size() - 1);
    return (from_axis_mm.cwiseAbs().array() <= half_mm_.array()).all() &&
           from_axis_mm.norm() <= radii_mm_[below];
  }
  const Vec2& half_mm() const { return half_mm_; }
  double SmallestRadiusMm() const { return *std::ranges::min_element(radii_mm_); }

 private:
  double height_mm_;
  Vec2 half_mm_;
  std::vector<double> radii_mm_;  ///< by depth in mm
};

struct Division {
  int columns, rows;
  int count() const { return columns * rows; }
};

/// Those whose rectangles fit, the fewest tiles first.
std::vector<Division> PossibleDivisions(const Vec2& size_mm, double strip_mm,
                                        const UsableField& field) {
  std::vector<Division> divisions;
  for (int columns = 1; columns <= kMaxSide; ++columns) {
    for (int rows = 1; rows <= kMaxSide; ++rows) {
      Vec2 half_mm = 0.5 * size_mm.cwiseQuotient(Vec2(columns, rows));
      if (columns > 1) half_mm.x() += strip_mm;
      if (rows > 1) half_mm.y() += strip_mm;
      if ((half_mm.array() > field.half_mm().array()).any()) continue;
      divisions.push_back({columns, rows});
    }
  }
  std::ranges::stable_sort(divisions, [](const Division& a, const Division& b) {
    return a.count() < b.count();
  });
  return divisions;
}

bool AllUsable(const PointList& points_mm, const std::vector<sort::BlockTile>& tiles,
               const UsableField& field) {
  return std::ranges::all_of(tiles, [&](const sort::BlockTile& tile) {
    return std::ranges::all_of(tile.members, [&](std::uint32_t i) {
      return field.Has(points_mm[i].head<2>() - tile.axis_mm, points_mm[i].z());
    });
  });
}

/// Whether the rectangles alone would do, which takes no time to see.
bool RectanglesFit(const PointList& points_mm, const Box3& extent,
                   const Division& division, const UsableField& field) {
  const Vec2 tile_mm =
      extent.size_mm().head<2>().cwiseQuotient(Vec2(division.columns, division.rows));
  const auto middle = [](double at, double tile, int count) {
    if (count == 1) return 0.5 * tile;
    return (std::clamp(std::floor(at / tile), 0.0, count - 1.0) + 0.5) * tile;
  };
  return std::ranges::all_of(points_mm, [&](const Vec3& p) {
    const Vec2 at = p.head<2>() - extent.min_mm.head<2>();
    const Vec2 axis(middle(at.x(), tile_mm.x(), division.columns),
                    middle(at.y(), tile_mm.y(), division.rows));
    return field.Has(at - axis, p.z());
  });
}

std::string TileName(std::size_t number) { return fmt::format("tile-{:03}", number); }

/// With a stage that carries the block.
JobSpec JobOfWholeBlock(const FrozenJob& job, const Vec2& moved_mm,
                        const Vec3& block_mm) {
  JobSpec spec = job.job();
  Vector3& size = *spec.mutable_block()->mutable_size_mm();
  size.set_x(block_mm.x());
  size.set_y(block_mm.y());
  spec.mutable_block_place()->set_x_mm(moved_mm.x());
  spec.mutable_block_place()->set_y_mm(moved_mm.y());
  return spec;
}

Status WriteTile(const FrozenJob& job, const PointList& points_mm,
                 const sort::BlockTile& tile, const Vec3& block_mm,
                 const fs::path& stem) {
  // From the whole block to the part of it whose middle is at the axis of the lens.
  const Vec2 moved_mm = 0.5 * BlockSizeOf(job.job()).head<2>() - tile.axis_mm;
  const bool on_stage = job.machine().head_over_block().has_block_stage();
  JobSpec spec = on_stage ? JobOfWholeBlock(job, moved_mm, block_mm) : job.job();
  Findings findings;
  CheckBlockPlace(spec, job.machine(), findings);
  if (!findings.found().empty()) {
    Error error = findings.found().front();
    error.message = stem.filename().string() + ": " + error.message;
    return tl::unexpected(std::move(error));
  }
  formats::PointTable table;
  for (const std::uint32_t i : tile.members) {
    Vec3 p = points_mm[i];
    if (!on_stage) p.head<2>() += moved_mm;
    table.points_mm.push_back(p);
  }
  INTAGLIO_TRY(formats::WritePoints(stem.string() + ".xyz", table));
  spec.clear_models();
  Model& model = *spec.add_models();
  model.set_file(stem.filename().string() + ".xyz");
  model.mutable_placement()->set_centre_in_block(false);
  spec.set_name(stem.filename().string());
  return WriteJobFile(stem.string() + ".textproto", spec);
}

}  // namespace

Result<Vec2> PartUnderHead(const MachineSpec& machine, const JobSpec& job) {
  if (!machine.has_head_over_block()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() +
                    ": tiles are for a scan head over the block; this machine "
                    "moves the focus by its axes",
                machine.name());
  }
  const Vec2 part_mm = -2 * BlockOriginOf(machine, job).head<2>();
  if ((part_mm.array() <= 0).any()) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("block_origin_mm: the axis of the lens is {:g}, {:g} mm from the "
                    "corner of the block, which must be above 0: give minus half of "
                    "the largest block that fits in the field",
                    0.5 * part_mm.x(), 0.5 * part_mm.y()),
        machine.name());
  }
  return part_mm;
}

Result<BlockTiling> ChooseTiles(const FrozenJob& job, const PointList& points_mm,
                                double strip_mm) {
  Box3 extent;
  for (const Vec3& p : points_mm) extent.Extend(p);
  const double height_mm = BlockSizeOf(job.job()).z();
  const UsableField field(job, std::max(0.0, height_mm - extent.min_mm.z()));
  sort::BlockTileOptions options;
  options.strip_mm = strip_mm;
  options.cone = PointConeOf(job);
  int tries = 0;
  for (const Division& division :
       PossibleDivisions(extent.size_mm().head<2>(), strip_mm, field)) {
    if (!RectanglesFit(points_mm, extent, division, field)) continue;
    options.columns = division.columns;
    options.rows = division.rows;
    auto tiles = sort::DivideIntoTiles(points_mm, options);
    if (AllUsable(points_mm, tiles, field)) {
      return BlockTiling{division.columns, division.rows, std::move(tiles)};
    }
    if (++tries == kMaxTries) break;
  }
  return Fail(
      ErrorCode::kOutsideBlock,
      fmt::format("no tiles of any size hold all points: {:.1f} mm below the face "
                  "there are cracks up to {:.2f} mm from the axis of the lens; take "
                  "more energy, a smaller aperture, a lower block or a shorter "
                  "--strip",
                  height_mm - extent.min_mm.z(), field.SmallestRadiusMm()),
      fmt::format("{:g}", field.SmallestRadiusMm()));
}

Status WriteTileJobs(const FrozenJob& job, const PointList& points_mm,
                     const BlockTiling& tiling, const Vec3& block_mm,
                     const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::string csv = "tile,points,corner_x_mm,corner_y_mm,move_x_mm,move_y_mm,job\n";
  Vec2 before_mm = tiling.tiles.front().axis_mm;
  for (std::size_t i = 0; i < tiling.tiles.size(); ++i) {
    const sort::BlockTile& tile = tiling.tiles[i];
    const std::string name = TileName(i + 1);
    INTAGLIO_TRY(WriteTile(job, points_mm, tile, block_mm, folder / name));
    const Vec2 move_mm = before_mm - tile.axis_mm;
    csv += fmt::format("{},{},{:.3f},{:.3f},{:.3f},{:.3f},{}.textproto\n", i + 1,
                       tile.members.size(), -tile.axis_mm.x(), -tile.axis_mm.y(),
                       move_mm.x() + 0.0, move_mm.y() + 0.0, name);
    before_mm = tile.axis_mm;
  }
  return io::WriteFileAtomically(folder / "tiles.csv", std::string_view(csv));
}

}  // namespace intaglio::client
