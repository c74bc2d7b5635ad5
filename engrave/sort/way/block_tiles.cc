#include "engrave/sort/way/block_tiles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

constexpr int kMaxSide = 1000;
constexpr std::uint32_t kNone = 0xffffffff;
// Cells of the map of cracks, and stretches of a seam that share an error.
constexpr double kCellMm = 1;
constexpr std::size_t kMaxCells = 4'000'000;

/// Tiles by their number, the order in which they are made.
struct Tiling {
  Box3 extent;
  int columns, rows;
  Vec2 tile_mm;

  std::uint32_t NumberAt(int column, int row) const {
    const int along = column % 2 == 0 ? row : rows - 1 - row;
    return static_cast<std::uint32_t>(column * rows + along);
  }
  Vec2 AxisOf(std::uint32_t number) const {
    const int column = static_cast<int>(number) / rows;
    const int along = static_cast<int>(number) % rows;
    const int row = column % 2 == 0 ? along : rows - 1 - along;
    return extent.min_mm.head<2>() + tile_mm.cwiseProduct(Vec2(column + 0.5, row + 0.5));
  }
};

/// The cracks of the points that have a tile, by places across.
class CrackMap {
 public:
  CrackMap(const PointList& points_mm, const Tiling& tiling, const BeamCone& cone)
      : points_mm_(points_mm), tiling_(tiling), cone_(cone) {
    const Vec2 size_mm = tiling.extent.size_mm().head<2>();
    cell_mm_ = std::max(kCellMm, size_mm.maxCoeff() / std::sqrt(double{kMaxCells}));
    columns_ = static_cast<int>(size_mm.x() / cell_mm_) + 1;
    rows_ = static_cast<int>(size_mm.y() / cell_mm_) + 1;
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  }

  void Add(std::uint32_t point, std::uint32_t tile) {
    const Vec3& p = points_mm_[point];
    Cell& cell = cells_[IndexOf(ColumnOf(p.x()), RowOf(p.y()))];
    cell.first_tile = std::min(cell.first_tile, tile);
    cell.cracks.push_back({point, tile});
  }

  /// An earlier tile with a crack in the beam of `tile` to the point.
  std::optional<std::uint32_t> FindEarlier(const Vec3& p, std::uint32_t tile) const {
    if (tile == 0) return std::nullopt;
    BeamCone cone = cone_;
    if (cone.lean) cone.lean->axis_mm = tiling_.AxisOf(tile);
    const Vec2 lean = cone.LeanAt(p);
    const double up_mm = tiling_.extent.max_mm.z() - p.z();
    const Vec2 reach_mm = Vec2::Constant(cone.ReachMm(up_mm));
    const Vec2 end_mm = p.head<2>() + up_mm * lean;
    const Vec2 low_mm = end_mm.cwiseMin(p.head<2>()) - reach_mm;
    const Vec2 high_mm = end_mm.cwiseMax(p.head<2>()) + reach_mm;
    for (int row = RowOf(low_mm.y()); row <= RowOf(high_mm.y()); ++row) {
      for (int column = ColumnOf(low_mm.x()); column <= ColumnOf(high_mm.x()); ++column) {
        const Cell& cell = cells_[IndexOf(column, row)];
        if (cell.first_tile >= tile) continue;
        for (const Crack& crack : cell.cracks) {
          if (crack.tile < tile && cone.Shades(points_mm_[crack.point] - p, lean))
            return crack.tile;
        }
      }
    }
    return std::nullopt;
  }

 private:
  struct Crack {
    std::uint32_t point, tile;
  };
  struct Cell {
    std::uint32_t first_tile = kNone;
    std::vector<Crack> cracks;
  };

  int ColumnOf(double x_mm) const {
    return static_cast<int>(
        std::clamp((x_mm - tiling_.extent.min_mm.x()) / cell_mm_, 0.0, columns_ - 1.0));
  }
  int RowOf(double y_mm) const {
    return static_cast<int>(
        std::clamp((y_mm - tiling_.extent.min_mm.y()) / cell_mm_, 0.0, rows_ - 1.0));
  }
  std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  const PointList& points_mm_;
  const Tiling& tiling_;
  BeamCone cone_;
  double cell_mm_;
  int columns_, rows_;
  std::vector<Cell> cells_;
};

/// The seams across one axis.
class Seams {
 public:
  /// `length_mm`: of a seam across.
  Seams(double tile_mm, int count, double strip_mm, double length_mm)
      : tile_mm_(tile_mm),
        count_(count),
        strip_mm_(strip_mm),
        stretches_(static_cast<std::size_t>(length_mm / kCellMm) + 1),
        error_(static_cast<std::size_t>(count) * stretches_, 0.0) {}

  /// 0..count - 1; `at_mm` and `along_mm` from the beginning of the extent.
  int Choose(double at_mm, double along_mm) {
    const int nominal = Clamped(at_mm / tile_mm_);
    if (strip_mm_ <= 0) return nominal;
    const int upper = Clamped(at_mm / tile_mm_ + 0.5);  // above the nearest seam
    const double from_seam_mm = at_mm - upper * tile_mm_;
    if (upper == 0 || std::abs(from_seam_mm) >= strip_mm_) return nominal;
    const double upper_share = 0.5 + 0.5 * from_seam_mm / strip_mm_;
    const auto stretch = std::min(
        static_cast<std::size_t>(std::max(0.0, along_mm) / kCellMm), stretches_ - 1);
    double& error = error_[static_cast<std::size_t>(upper) * stretches_ + stretch];
    error += upper_share;
    if (error < 0.5) return upper - 1;
    error -= 1;
    return upper;
  }

 private:
  int Clamped(double tile) const {
    return std::clamp(static_cast<int>(std::floor(tile)), 0, count_ - 1);
  }

  double tile_mm_;
  int count_;
  double strip_mm_;
  std::size_t stretches_;
  std::vector<double> error_;
};

Tiling TilingOf(const PointList& points_mm, const BlockTileOptions& options) {
  Require(options.columns >= 1 && options.columns <= kMaxSide && options.rows >= 1 &&
              options.rows <= kMaxSide,
          "{} x {} tiles", options.columns, options.rows);
  RequireUsable(options.cone);
  Tiling tiling;
  for (const Vec3& p : points_mm) tiling.extent.Extend(p);
  tiling.columns = options.columns;
  tiling.rows = options.rows;
  tiling.tile_mm = tiling.extent.size_mm().head<2>().cwiseQuotient(
      Vec2(options.columns, options.rows));
  // All points in one line have no width.
  tiling.tile_mm = tiling.tile_mm.cwiseMax(Vec2::Constant(1e-9));
  Require(options.strip_mm >= 0, "strip_mm must not be negative, is {}",
          options.strip_mm);
  return tiling;
}

}  // namespace

std::vector<BlockTile> DivideIntoTiles(const PointList& points_mm,
                                       const BlockTileOptions& options) {
  if (points_mm.empty()) return {};
  const Tiling tiling = TilingOf(points_mm, options);
  const Vec2 size_mm = tiling.extent.size_mm().head<2>();
  const double strip_mm = std::min(options.strip_mm, 0.25 * tiling.tile_mm.minCoeff());
  Seams of_columns(tiling.tile_mm.x(), tiling.columns, strip_mm, size_mm.y());
  Seams of_rows(tiling.tile_mm.y(), tiling.rows, strip_mm, size_mm.x());
  CrackMap cracks(points_mm, tiling, options.cone);
  std::vector<std::uint32_t> downward(points_mm.size());
  std::iota(downward.begin(), downward.end(), 0U);
  std::ranges::sort(downward, [&](std::uint32_t a, std::uint32_t b) {
    return points_mm[a].z() != points_mm[b].z() ? points_mm[a].z() > points_mm[b].z()
                                                : a < b;
  });
  std::vector<BlockTile> tiles(static_cast<std::size_t>(tiling.columns) *
                               static_cast<std::size_t>(tiling.rows));
  for (const std::uint32_t point : downward) {
    const Vec3& p = points_mm[point];
    const Vec2 at_mm = p.head<2>() - tiling.extent.min_mm.head<2>();
    const int column = of_columns.Choose(at_mm.x(), at_mm.y());
    std::uint32_t tile = tiling.NumberAt(column, of_rows.Choose(at_mm.y(), at_mm.x()));
    while (const auto earlier = cracks.FindEarlier(p, tile)) tile = *earlier;
    cracks.Add(point, tile);
    tiles[tile].members.push_back(point);
  }
  for (std::uint32_t number = 0; number < tiles.size(); ++number) {
    tiles[number].axis_mm = tiling.AxisOf(number);
    std::ranges::sort(tiles[number].members);
  }
  std::erase_if(tiles, [](const BlockTile& tile) { return tile.members.empty(); });
  return tiles;
}

}  // namespace intaglio::sort
