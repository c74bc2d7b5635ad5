#include "engrave/contour/milling/nest_outlines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "engrave/contour/region/region_index.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// The sheet's longer side has these cells: 0.75 mm of 600.
constexpr double kCellsALong = 800;

/// A row of cells, as bits.
class BitRow {
 public:
  explicit BitRow(int count) : groups_(static_cast<std::size_t>(count + 63) / 64) {}

  void Set(int at) { groups_[At(at)] |= std::uint64_t{1} << (at & 63); }
  void Or(const BitRow& other) {
    for (std::size_t i = 0; i < groups_.size(); ++i) groups_[i] |= other.groups_[i];
  }
  /// Cell x of the result is cell x + by of this.
  BitRow Down(int by) const {
    BitRow moved = *this;
    const std::size_t whole = At(by);
    const int rest = by & 63;
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      const std::uint64_t low = GroupAt(i + whole), high = GroupAt(i + whole + 1);
      moved.groups_[i] = rest == 0 ? low : low >> rest | high << (64 - rest);
    }
    return moved;
  }
  /// Cell x of the result: one of the cells x + first .. x + last is set.
  BitRow AnyOf(int first, int last) const {
    BitRow any = *this;
    int reach = 1;
    for (const int length = last - first + 1; reach < length;) {
      const int step = std::min(reach, length - reach);
      any.Or(any.Down(step));
      reach += step;
    }
    return any.Down(first);
  }
  /// The first cell that is not set, below `end`.
  std::optional<int> FirstFree(int end) const {
    for (int at = 0; at < end; at += 64) {
      const std::uint64_t free = ~groups_[At(at)];
      if (free == 0) continue;
      const int found = at + __builtin_ctzll(free);
      if (found < end) return found;
    }
    return std::nullopt;
  }
  bool empty() const {
    return std::ranges::all_of(groups_, [](std::uint64_t group) { return group == 0; });
  }

 private:
  static std::size_t At(int cell) { return static_cast<std::size_t>(cell) / 64; }
  std::uint64_t GroupAt(std::size_t at) const {
    return at < groups_.size() ? groups_[at] : 0;
  }

  std::vector<std::uint64_t> groups_;
};

/// Cells first .. last of a row.
struct CellRun {
  int first, last;
  bool operator==(const CellRun&) const = default;
};

/// A part in one of its directions, with `border` cells around its box.
struct CellMask {
  std::vector<std::vector<CellRun>> rows;
  bool operator==(const CellMask&) const = default;
};

struct Direction {
  Vec2 corner_mm;           ///< of its box, least x and y
  Vec2 sides_mm;            ///< of its box
  CellMask covered, apart;  ///< what it touches, and what is nearer than the gap
  double middle_mm = 0;     ///< of what it touches, above its box's bottom
};

/// Which of a part's directions is chosen.
enum class Choice {
  kLowestTop,
  kLowestMiddle,  ///< of what it covers
};

class OutlineNester {
 public:
  OutlineNester(std::span<const Region> parts, const NestOptions& options, Choice choice)
      : parts_(parts),
        options_(options),
        choice_(choice),
        cell_mm_(options.sheet_mm.maxCoeff() / kCellsALong),
        room_mm_(options.sheet_mm - Vec2::Constant(2 * options.margin_mm)),
        border_(static_cast<int>(options.gap_mm / cell_mm_) + 3),
        columns_(static_cast<int>(room_mm_.x() / cell_mm_) + 2 * border_ + 2),
        rows_(static_cast<int>(room_mm_.y() / cell_mm_) + 2 * border_ + 2) {}

  Result<Nest> Run() {
    std::vector<std::uint32_t> order(parts_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return LongerSide(a) > LongerSide(b);
    });
    nest_.parts.resize(parts_.size());
    for (const std::uint32_t part : order) INTAGLIO_TRY(Put(part));
    nest_.sheet_count = static_cast<std::uint32_t>(sheets_.size());
    return std::move(nest_);
  }

 private:
  using Sheet = std::vector<BitRow>;
  struct Found {
    int turns = 0, column = 0, row = 0;
    double height_mm = 0;  ///< of what choice_ compares
  };

  double LongerSide(std::uint32_t part) const {
    const EdgeBox box = BoxOfRegion(parts_[part]);
    return (box.max_mm - box.min_mm).maxCoeff();
  }

  Status Put(std::uint32_t part) {
    std::vector<Direction> directions = DirectionsOf(parts_[part]);
    // Copies of the part before: where that found no place, they find none.
    const bool copy = directions.size() == directions_.size() &&
                      std::ranges::equal(directions, directions_, {}, &Direction::apart,
                                         &Direction::apart) &&
                      std::ranges::equal(directions, directions_, {}, &Direction::covered,
                                         &Direction::covered);
    if (!copy) searched_.clear();
    directions_ = std::move(directions);
    for (std::size_t sheet = 0; sheet < sheets_.size(); ++sheet) {
      if (const auto found = PlaceOn(sheet)) return Lay(part, sheet, *found), Status();
    }
    sheets_.emplace_back(static_cast<std::size_t>(rows_), BitRow(columns_));
    const auto found = PlaceOn(sheets_.size() - 1);
    if (!found) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("part {} does not fit into a sheet of {:.4g} x {:.4g} mm",
                              part, options_.sheet_mm.x(), options_.sheet_mm.y()));
    }
    return Lay(part, sheets_.size() - 1, *found), Status();
  }

  std::vector<Direction> DirectionsOf(const Region& part) const {
    std::vector<Direction> directions;
    for (int turns = 0; turns < (options_.turn ? 4 : 1); ++turns) {
      const Region turned = Placed(part, {0, 0, Vec2::Zero(), turns});
      const EdgeBox box = BoxOfRegion(turned);
      const double half_diagonal = cell_mm_ * std::sqrt(0.5);
      directions.push_back({box.min_mm, box.max_mm - box.min_mm,
                            MaskOf(turned, box, half_diagonal),
                            MaskOf(turned, box, half_diagonal + options_.gap_mm)});
      directions.back().middle_mm = MiddleOf(directions.back().covered);
    }
    return directions;
  }

  double MiddleOf(const CellMask& mask) const {
    double cells = 0, moment = 0;
    for (std::size_t row = 0; row < mask.rows.size(); ++row) {
      for (const CellRun& run : mask.rows[row]) {
        cells += run.last - run.first + 1;
        moment += (run.last - run.first + 1) * (static_cast<double>(row) - border_);
      }
    }
    return cell_mm_ * moment / cells;
  }

  /// Cells whose middle is inside, or not farther than that from the border.
  CellMask MaskOf(const Region& part, const EdgeBox& box, double distance_mm) const {
    const Vec2 sides = box.max_mm - box.min_mm;
    const int columns = static_cast<int>(sides.x() / cell_mm_) + 2 * border_ + 1;
    const int rows = static_cast<int>(sides.y() / cell_mm_) + 2 * border_ + 1;
    std::vector<std::vector<bool>> cells(
        static_cast<std::size_t>(rows),
        std::vector<bool>(static_cast<std::size_t>(columns)));
    const auto middle_of = [&](int column, int row) {
      return Vec2(box.min_mm +
                  cell_mm_ * Vec2(column - border_ + 0.5, row - border_ + 0.5));
    };
    const RegionIndex index(part);
    for (const Edge& edge : index.edges()) {
      const EdgeBox around = BoxOfEdge(edge);
      const auto cell_of = [&](double mm, int axis) {
        return border_ + static_cast<int>(std::floor((mm - box.min_mm[axis]) / cell_mm_));
      };
      const int x0 = std::max(0, cell_of(around.min_mm.x() - distance_mm, 0));
      const int x1 = std::min(columns - 1, cell_of(around.max_mm.x() + distance_mm, 0));
      const int y0 = std::max(0, cell_of(around.min_mm.y() - distance_mm, 1));
      const int y1 = std::min(rows - 1, cell_of(around.max_mm.y() + distance_mm, 1));
      for (int row = y0; row <= y1; ++row) {
        for (int column = x0; column <= x1; ++column) {
          auto cell = cells[static_cast<std::size_t>(row)].begin() + column;
          if (!*cell && DistanceTo(edge, middle_of(column, row)) <= distance_mm)
            *cell = true;
        }
      }
    }
    CellMask mask;
    for (int row = 0; row < rows; ++row) {
      std::vector<CellRun>& runs = mask.rows.emplace_back();
      for (int column = 0; column < columns; ++column) {
        const bool covers =
            cells[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] ||
            index.IsInside(middle_of(column, row));
        if (!covers) continue;
        if (!runs.empty() && runs.back().last == column - 1)
          ++runs.back().last;
        else
          runs.push_back({column, column});
      }
    }
    return mask;
  }

  std::optional<Found> PlaceOn(std::size_t sheet) {
    std::optional<Found> best;
    searched_.resize(std::max(searched_.size(), sheet + 1));
    std::vector<int>& from = searched_[sheet];
    from.resize(directions_.size());
    for (std::size_t k = 0; k < directions_.size(); ++k) {
      const Direction& direction = directions_[k];
      const Vec2 free_mm = room_mm_ - direction.sides_mm;
      if (free_mm.minCoeff() < -1e-9) continue;
      const int columns = static_cast<int>(free_mm.x() / cell_mm_ + 1e-6) + 1;
      const int rows = static_cast<int>(free_mm.y() / cell_mm_ + 1e-6) + 1;
      for (int& row = from[k]; row < rows; ++row) {
        const double height_mm =
            row * cell_mm_ + (choice_ == Choice::kLowestTop ? direction.sides_mm.y()
                                                            : direction.middle_mm);
        if (best && height_mm > best->height_mm - 1e-9) break;
        const auto column = FreeColumn(sheets_[sheet], direction.apart, row, columns);
        if (!column) continue;
        best = Found{static_cast<int>(k), *column, row, height_mm};
        break;
      }
    }
    return best;
  }

  static std::optional<int> FreeColumn(const Sheet& sheet, const CellMask& mask, int row,
                                       int columns) {
    BitRow blocked = sheet[0].Down(1 << 20);
    for (std::size_t k = 0; k < mask.rows.size(); ++k) {
      const BitRow& cells = sheet[static_cast<std::size_t>(row) + k];
      if (cells.empty()) continue;
      for (const CellRun& run : mask.rows[k])
        blocked.Or(cells.AnyOf(run.first, run.last));
      if (!blocked.FirstFree(columns)) return std::nullopt;
    }
    return blocked.FirstFree(columns);
  }

  void Lay(std::uint32_t part, std::size_t sheet, const Found& found) {
    const Direction& direction = directions_[static_cast<std::size_t>(found.turns)];
    for (std::size_t k = 0; k < direction.covered.rows.size(); ++k) {
      BitRow& cells = sheets_[sheet][static_cast<std::size_t>(found.row) + k];
      for (const CellRun& run : direction.covered.rows[k])
        for (int x = run.first; x <= run.last; ++x) cells.Set(found.column + x);
    }
    const Vec2 at =
        Vec2::Constant(options_.margin_mm) + cell_mm_ * Vec2(found.column, found.row);
    nest_.parts[part] = {part, static_cast<std::uint32_t>(sheet),
                         at - direction.corner_mm, found.turns};
  }

  std::span<const Region> parts_;
  const NestOptions& options_;
  Choice choice_;
  double cell_mm_;
  Vec2 room_mm_;
  int border_, columns_, rows_;
  std::vector<Sheet> sheets_;
  std::vector<Direction> directions_;  ///< of the part in hand
  /// Each sheet has no place below this row, for each direction.
  std::vector<std::vector<int>> searched_;
  Nest nest_;
};

}  // namespace

std::vector<Nest> NestOutlines(std::span<const Region> parts,
                               const NestOptions& options) {
  std::vector<Nest> nests;
  for (const Choice choice : {Choice::kLowestTop, Choice::kLowestMiddle}) {
    if (auto nest = OutlineNester(parts, options, choice).Run())
      nests.push_back(std::move(*nest));
  }
  return nests;
}

}  // namespace intaglio::contour
