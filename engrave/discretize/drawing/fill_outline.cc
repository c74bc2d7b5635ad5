#include "engrave/discretize/drawing/fill_outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "engrave/core/try.h"
#include "engrave/discretize/spacing/candidate_limit.h"
#include "engrave/discretize/spacing/statistics.h"

namespace intaglio::discretize {
namespace {

// Candidates around a point, at the distance: 48 of them leave no arc longer than 0.13
// distances unchecked.
constexpr int kRing = 48;

struct Edge {
  Vec2 low;
  Vec2 high;
  int winding = 0;  // +1 upwards
};

struct Crossing {
  double x = 0;
  int winding = 0;
};

/// Decides what is inside from the edges that cross the row at a height.
class Inside {
 public:
  Inside(const std::vector<std::vector<Vec2>>& polygons, bool even_odd, double row_mm)
      : even_odd_(even_odd), row_mm_(row_mm) {
    for (const auto& polygon : polygons) {
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2& p = polygon[i];
        const Vec2& q = polygon[(i + 1) % polygon.size()];
        if (p.y() < q.y()) edges_.push_back({p, q, 1});
        if (p.y() > q.y()) edges_.push_back({q, p, -1});
      }
    }
    for (const Edge& edge : edges_) {
      lowest_ = std::min(lowest_, edge.low.y());
      highest_ = std::max(highest_, edge.high.y());
    }
  }

  /// Fails when the rows would hold more edges than a job has points.
  Status Build() {
    if (edges_.empty()) return {};
    INTAGLIO_TRY(CheckCandidateCount((highest_ - lowest_) / row_mm_));
    double entries = 0;
    for (const Edge& edge : edges_) {
      entries += static_cast<double>(RowOf(edge.high.y()) - RowOf(edge.low.y()) + 1);
    }
    INTAGLIO_TRY(CheckCandidateCount(entries));
    rows_.resize(RowOf(highest_) + 1);
    for (std::uint32_t i = 0; i < edges_.size(); ++i) {
      const std::size_t last = RowOf(edges_[i].high.y());
      for (std::size_t row = RowOf(edges_[i].low.y()); row <= last; ++row) {
        rows_[row].push_back(i);
      }
    }
    return {};
  }

  double lowest() const { return lowest_; }
  double highest() const { return highest_; }

  /// Crossings of the outline at the height, by x. An edge includes its lower end, not
  /// its upper one.
  void CrossingsAt(double y, std::vector<Crossing>& crossings) const {
    crossings.clear();
    ForEachAt(y, [&](double x, int winding) { crossings.push_back({x, winding}); });
    std::ranges::sort(crossings, {}, &Crossing::x);
  }
  bool Has(const Vec2& p) const {
    int winding = 0, count = 0;
    ForEachAt(p.y(), [&](double x, int turn) {
      if (x > p.x()) {
        winding += turn;
        ++count;
      }
    });
    return IsIn(winding, count);
  }
  bool IsIn(int winding, int count) const {
    return even_odd_ ? count % 2 != 0 : winding != 0;
  }

 private:
  std::size_t RowOf(double y) const {
    return static_cast<std::size_t>((y - lowest_) / row_mm_);
  }
  template <typename Visit>
  void ForEachAt(double y, const Visit& visit) const {
    if (!(y >= lowest_ && y < highest_)) return;
    for (const std::uint32_t i : rows_[RowOf(y)]) {
      const Edge& edge = edges_[i];
      if (y < edge.low.y() || y >= edge.high.y()) continue;
      const double share = (y - edge.low.y()) / (edge.high.y() - edge.low.y());
      visit(edge.low.x() + share * (edge.high.x() - edge.low.x()), edge.winding);
    }
  }

  bool even_odd_;
  double row_mm_;
  std::vector<Edge> edges_;
  std::vector<std::vector<std::uint32_t>> rows_;
  double lowest_ = std::numeric_limits<double>::infinity();
  double highest_ = -std::numeric_limits<double>::infinity();
};

/// Points in cells as wide as the distance, so that only nine cells have to be checked
/// for points that are too near.
class Spaced {
 public:
  explicit Spaced(double distance_mm) : distance_mm_(distance_mm) {}

  void Add(const Vec2& p) { cells_[KeyOf(Column(p.x()), Column(p.y()))].push_back(p); }
  bool Fits(const Vec2& p) const {
    const std::int64_t x = Column(p.x()), y = Column(p.y());
    const double smallest = distance_mm_ * distance_mm_;
    for (std::int64_t i = x - 1; i <= x + 1; ++i) {
      for (std::int64_t j = y - 1; j <= y + 1; ++j) {
        const auto found = cells_.find(KeyOf(i, j));
        if (found == cells_.end()) continue;
        for (const Vec2& other : found->second) {
          if ((other - p).squaredNorm() < smallest) return false;
        }
      }
    }
    return true;
  }

 private:
  std::int64_t Column(double x) const {
    return static_cast<std::int64_t>(std::floor(x / distance_mm_));
  }
  static std::uint64_t KeyOf(std::int64_t x, std::int64_t y) {
    return (static_cast<std::uint64_t>(x) << 32) ^
           (static_cast<std::uint64_t>(y) & 0xFFFFFFFFU);
  }
  struct Mix {
    std::size_t operator()(std::uint64_t key) const {
      key *= 0x9E3779B97F4A7C15ULL;
      return key ^ (key >> 32);
    }
  };
  double distance_mm_;
  std::unordered_map<std::uint64_t, std::vector<Vec2>, Mix> cells_;
};

/// Calls visit(y, shift of the row's lattice, from, to) for the parts of the rows that
/// are inside.
template <typename Visit>
void ForEachSpan(const Inside& inside, double row_mm, double pitch_mm,
                 const Visit& visit) {
  std::vector<Crossing> crossings;
  for (double row = std::ceil(inside.lowest() / row_mm); row * row_mm < inside.highest();
       ++row) {
    inside.CrossingsAt(row * row_mm, crossings);
    const double shift = std::fmod(row, 2) == 0 ? 0 : pitch_mm / 2;
    int winding = 0;
    for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
      winding += crossings[i].winding;
      if (!inside.IsIn(winding, static_cast<int>(i) + 1)) continue;
      visit(row * row_mm, shift, crossings[i].x, crossings[i + 1].x);
    }
  }
}

class Filler {
 public:
  Filler(const Inside& inside, const std::vector<Vec2>& kept, double distance_mm,
         std::vector<Vec2>& points)
      : inside_(inside),
        // Rounding may not bring lattice neighbours nearer than the distance.
        pitch_mm_(distance_mm * kRoundingAllowance),
        spaced_(distance_mm),
        outline_(3 * distance_mm),
        points_(points),
        front_(kept) {
    for (const Vec2& p : kept) {
      spaced_.Add(p);
      outline_.Add(p);
    }
  }

  void AddLattice(double row_mm) {
    ForEachSpan(inside_, row_mm, pitch_mm_,
                [&](double y, double shift, double from, double to) {
                  for (double k = std::ceil((from - shift) / pitch_mm_);
                       k * pitch_mm_ + shift < to; ++k) {
                    const Vec2 p(k * pitch_mm_ + shift, y);
                    if (spaced_.Fits(p)) Place(p);
                  }
                });
  }

  /// A point that can still be placed can be moved until it is at the distance from some
  /// point; in the middle of the lattice none can be placed.
  void AddBetween() {
    for (std::size_t i = 0; i < front_.size(); ++i) {
      const Vec2 around = front_[i];
      for (int step = 0; step < kRing; ++step) {
        const double angle = 2 * std::numbers::pi * step / kRing;
        const Vec2 p = around + pitch_mm_ * Vec2(std::cos(angle), std::sin(angle));
        if (spaced_.Fits(p) && inside_.Has(p)) Place(p);
      }
    }
  }

 private:
  void Place(const Vec2& p) {
    points_.push_back(p);
    spaced_.Add(p);
    if (!outline_.Fits(p)) front_.push_back(p);
  }

  const Inside& inside_;
  double pitch_mm_;
  Spaced spaced_;
  Spaced outline_;
  std::vector<Vec2>& points_;
  std::vector<Vec2> front_;  ///< points that may have free space beside them
};

}  // namespace

Status AddInnerPoints(const std::vector<std::vector<Vec2>>& polygons_mm,
                      const std::vector<Vec2>& kept_mm, const OutlineFill& fill,
                      std::vector<Vec2>& points_mm) {
  const double pitch_mm = fill.distance_mm * kRoundingAllowance;
  const double row_mm = pitch_mm * std::numbers::sqrt3 / 2;
  Inside inside(polygons_mm, fill.even_odd, row_mm);
  INTAGLIO_TRY(inside.Build());
  if (!(inside.highest() > inside.lowest())) return {};
  // Counted before they are placed, so that too many are reported at once.
  double count = 0;
  ForEachSpan(inside, row_mm, pitch_mm, [&](double, double, double from, double to) {
    count += (to - from) / pitch_mm;
  });
  INTAGLIO_TRY(CheckCandidateCount(count));
  Filler filler(inside, kept_mm, fill.distance_mm, points_mm);
  filler.AddLattice(row_mm);
  filler.AddBetween();
  return {};
}

}  // namespace intaglio::discretize
