#include "engrave/mark/jump_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engrave/mark/visits.h"

namespace intaglio::mark {
namespace {

/// The ends that are left, in square cells.
class EndGrid {
 public:
  EndGrid(const Ends& ends, bool may_reverse) : ends_(ends), taken_(ends.size(), 0) {
    Vec2 high = Vec2::Constant(-std::numeric_limits<double>::infinity());
    low_ = -high;
    for (std::uint32_t i = 0; i < ends.size(); ++i) {
      for (const bool back : {false, true}) {
        low_ = low_.cwiseMin(ends.Begin({i, back}));
        high = high.cwiseMax(ends.Begin({i, back}));
      }
    }
    const Vec2 size = high - low_;
    cell_ = std::max({std::sqrt(size.x() * size.y() / static_cast<double>(ends.size())),
                      std::max(size.x(), size.y()) / 4000, 1e-9});
    columns_ = static_cast<int>(size.x() / cell_) + 1;
    rows_ = static_cast<int>(size.y() / cell_) + 1;
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (std::uint32_t i = 0; i < ends.size(); ++i) {
      Add({i, false});
      if (may_reverse) Add({i, true});
    }
  }

  /// The nearest one; of equally near ones that with the lowest number. There is one.
  Visit TakeNearest(const Vec2& from) {
    const int cx = Column(from.x()), cy = Row(from.y());
    std::optional<Visit> best;
    double best_mm = std::numeric_limits<double>::infinity();
    const double border_mm = BorderMm(from, cx, cy);
    for (int ring = 0; ring <= std::max(columns_, rows_); ++ring) {
      // All of this ring is at least this far.
      if (best && best_mm < (ring - 1) * cell_ + border_mm) break;
      for (int y = cy - ring; y <= cy + ring; ++y) {
        const int step = std::abs(y - cy) == ring ? 1 : std::max(1, 2 * ring);
        for (int x = cx - ring; x <= cx + ring; x += step)
          Search(x, y, from, best, best_mm);
      }
    }
    taken_[best->mark] = 1;
    return *best;
  }

 private:
  /// How far the borders of its cell are at least; 0 outside of the grid.
  double BorderMm(const Vec2& from, int column, int row) const {
    const Vec2 within = from - low_ - cell_ * Vec2(column, row);
    const double nearest_mm = std::min(within.minCoeff(), cell_ - within.maxCoeff());
    return std::max(0.0, nearest_mm - 1e-6 * cell_);  // less what rounding does
  }
  int Column(double x) const {
    return std::clamp(static_cast<int>((x - low_.x()) / cell_), 0, columns_ - 1);
  }
  int Row(double y) const {
    return std::clamp(static_cast<int>((y - low_.y()) / cell_), 0, rows_ - 1);
  }
  std::vector<Visit>& CellAt(int x, int y) {
    return cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(x)];
  }
  void Add(const Visit& visit) {
    const Vec2& p = ends_.Begin(visit);
    CellAt(Column(p.x()), Row(p.y())).push_back(visit);
  }

  void Search(int x, int y, const Vec2& from, std::optional<Visit>& best,
              double& best_mm) {
    if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return;
    std::vector<Visit>& cell = CellAt(x, y);
    std::erase_if(cell, [&](const Visit& v) { return taken_[v.mark] != 0; });
    for (const Visit& v : cell) {
      const double square = (ends_.Begin(v) - from).squaredNorm();
      if (square > (1 + kMargin) * best_mm * best_mm) continue;
      const double d = std::sqrt(square);
      const bool nearer = d < best_mm || (d == best_mm && best && v.mark < best->mark);
      if (nearer) best = v, best_mm = d;
    }
  }

  const Ends& ends_;
  std::vector<std::uint8_t> taken_;  // bytes are read faster than bits
  Vec2 low_ = Vec2::Zero();
  double cell_ = 1;
  int columns_ = 1, rows_ = 1;
  std::vector<std::vector<Visit>> cells_;
};

/// The same way from its end to its beginning.
void TurnMarkBack(Mark& mark) {
  if (mark.closed) return;
  std::reverse(mark.places.begin(), mark.places.end());
  for (std::size_t i = 0; i + 1 < mark.places.size(); ++i) {
    mark.places[i].bulge = -mark.places[i + 1].bulge;
    mark.places[i].dark = mark.places[i + 1].dark;
  }
  mark.places.back().bulge = 0;
  mark.places.back().dark = false;
}

/// The place of a closed mark at which the ways to it and on from it are shortest, the
/// first of several.
std::size_t NearestPlace(const Mark& mark, const Vec2& from_mm, const Vec2* next_mm) {
  std::size_t nearest = 0;
  double shortest_mm = std::numeric_limits<double>::infinity();
  double far = shortest_mm;
  for (std::size_t i = 0; i < mark.places.size(); ++i) {
    const Vec2& at_mm = mark.places[i].at_mm;
    if ((at_mm - from_mm).squaredNorm() > far) continue;
    const double on_mm = next_mm != nullptr ? (*next_mm - at_mm).norm() : 0;
    const double way_mm = (at_mm - from_mm).norm() + on_mm;
    if (!(way_mm < shortest_mm)) continue;
    shortest_mm = way_mm, nearest = i;
    far = (1 + kMargin) * way_mm * way_mm;
  }
  return nearest;
}

/// Closed marks begin nearest to where the beam comes from; kept where that is shorter.
void BeginNearest(std::vector<Mark>& marks, const Vec2& start_mm) {
  Vec2 from = start_mm;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    Mark& mark = marks[i];
    if (mark.closed) {
      const Vec2* next =
          i + 1 < marks.size() ? &marks[i + 1].places.front().at_mm : nullptr;
      const auto nearest = NearestPlace(mark, from, next);
      // Not std::ranges::rotate: clang 14, which builds the fuzz targets, cannot.
      std::rotate(mark.places.begin(),
                  mark.places.begin() + static_cast<std::ptrdiff_t>(nearest),
                  mark.places.end());
    }
    from = mark.closed ? mark.places.front().at_mm : mark.places.back().at_mm;
  }
}

/// JumpLength of the marks in this order.
double JumpLength(const Ends& ends, const std::vector<Visit>& order,
                  const Vec2& start_mm) {
  Vec2 from = start_mm;
  double length_mm = 0;
  for (const Visit& visit : order) {
    length_mm += (ends.Begin(visit) - from).norm();
    from = ends.End(visit);
  }
  return length_mm;
}

}  // namespace

double JumpLength(const std::vector<Mark>& marks, const Vec2& start_mm) {
  Vec2 from = start_mm;
  double length_mm = 0;
  for (const Mark& mark : marks) {
    length_mm += (mark.places.front().at_mm - from).norm();
    from = mark.closed ? mark.places.front().at_mm : mark.places.back().at_mm;
  }
  return length_mm;
}

std::vector<Mark> OrderByJumps(std::vector<Mark> marks, const JumpOrderOptions& options) {
  if (marks.empty()) return marks;
  const Ends ends(marks);
  std::vector<Visit> order;
  order.reserve(marks.size());
  {
    EndGrid grid(ends, options.may_reverse);
    Vec2 from = options.start_mm;
    while (order.size() < marks.size()) {
      order.push_back(grid.TakeNearest(from));
      from = ends.End(order.back());
    }
  }
  ImproveVisits(ends, options.start_mm, options.may_reverse, order);
  if (JumpLength(ends, order, options.start_mm) <= JumpLength(marks, options.start_mm)) {
    std::vector<Mark> ordered;
    ordered.reserve(marks.size());
    for (const Visit& visit : order) {
      ordered.push_back(std::move(marks[visit.mark]));
      if (visit.back) TurnMarkBack(ordered.back());
    }
    marks = std::move(ordered);
  }
  BeginNearest(marks, options.start_mm);
  return marks;
}

}  // namespace intaglio::mark
