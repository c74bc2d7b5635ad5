#include "engrave/discretize/picture/halftone_settle.h"

#include <algorithm>
#include <cmath>

// Lloyd's relaxation on a raster of half the grid's step: every cell of the raster goes
// to the nearest point (two sweeps that pass on the nearest point found so far,
// Danielsson 1980), and the point to the weighted middle of its cells. Points settle to a
// density that grows with the square root of the weight (Du, Faber and Gunzburger 1999,
// in two dimensions), so the weight is the density squared. It is limited to 1.5 times
// the density at the point itself; otherwise points of a dark place would move into a
// bright neighbouring place.

namespace intaglio::discretize {
namespace {

constexpr int kNone = -1;

class Settling {
 public:
  Settling(const HalftoneGrid& grid, const DensityOf& density,
           const SettleOptions& options, PanelPoints& points)
      : options_(options),
        points_(points),
        began_(points),
        size_mm_(grid.width_mm, grid.height_mm) {
    width_ = 2 * (grid.columns - 2);
    height_ = 2 * (grid.rows - 2);
    cell_mm_ = size_mm_.cwiseQuotient(Vec2(width_, height_));
    owner_.resize(Count());
    density_.resize(Count());
    std::vector<float> places;
    places.reserve(grid.brightness.size());
    for (const float b : grid.brightness)
      places.push_back(static_cast<float>(density(b)));
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        density_[At(x, y)] = places[NearestPlace(grid, x, y)];
      }
    }
    columns_ = static_cast<int>(size_mm_.x() / options.spacing_mm) + 1;
    rows_ = static_cast<int>(size_mm_.y() / options.spacing_mm) + 1;
    first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                  kNone);
    following_.assign(points.size(), kNone);
    for (std::size_t i = 0; i < points.size(); ++i) Link(static_cast<int>(i));
  }

  void Round() {
    Seed();
    Sweep(1);
    Sweep(-1);
    FindMiddles();
    for (std::size_t i = 0; i < points_.size(); ++i) Move(i);
  }

 private:
  std::size_t Count() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }
  std::size_t At(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  Vec2 CentreOf(int x, int y) const {
    return {(x + 0.5) * cell_mm_.x(), (y + 0.5) * cell_mm_.y()};
  }
  std::size_t CellOf(const Vec2& p) const {
    return At(std::clamp(static_cast<int>(p.x() / cell_mm_.x()), 0, width_ - 1),
              std::clamp(static_cast<int>(p.y() / cell_mm_.y()), 0, height_ - 1));
  }
  std::size_t NearestPlace(const HalftoneGrid& grid, int x, int y) const {
    const Vec2 away = CentreOf(x, y) - grid.At(0, 0);
    const int row = std::clamp(static_cast<int>(std::lround(away.y() / grid.step_y_mm)),
                               0, grid.rows - 1);
    const double along = CentreOf(x, y).x() - grid.At(0, row).x();
    const int column = std::clamp(static_cast<int>(std::lround(along / grid.step_x_mm)),
                                  0, grid.columns - 1);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) +
           static_cast<std::size_t>(column);
  }

  // ---- Which point is nearest to a cell of the raster
  void Seed() {
    std::fill(owner_.begin(), owner_.end(), kNone);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      int& owner = owner_[CellOf(points_[i])];
      if (owner == kNone) owner = static_cast<int>(i);
    }
  }
  double SquareTo(int owner, const Vec2& centre) const {
    return (points_[static_cast<std::size_t>(owner)] - centre).squaredNorm();
  }
  void Offer(int owner, const Vec2& centre, int& best, double& square) const {
    if (owner == kNone || owner == best) return;
    const double other = SquareTo(owner, centre);
    if (other < square) {
      square = other;
      best = owner;
    }
  }
  /// Rows upwards (direction 1) or downwards; within a row in both directions.
  void Sweep(int direction) {
    for (int i = 0; i < height_; ++i) {
      const int y = direction > 0 ? i : height_ - 1 - i;
      SweepRow(y, i > 0 ? y - direction : y, 1);
      SweepRow(y, y, -1);
    }
  }
  void SweepRow(int y, int before, int direction) {
    for (int j = 0; j < width_; ++j) {
      const int x = direction > 0 ? j : width_ - 1 - j;
      const Vec2 centre = CentreOf(x, y);
      int& best = owner_[At(x, y)];
      double square = best == kNone ? std::numeric_limits<double>::infinity()
                                    : SquareTo(best, centre);
      if (j > 0) Offer(owner_[At(x - direction, y)], centre, best, square);
      if (before == y) continue;
      Offer(owner_[At(x, before)], centre, best, square);
      if (x > 0) Offer(owner_[At(x - 1, before)], centre, best, square);
      if (x + 1 < width_) Offer(owner_[At(x + 1, before)], centre, best, square);
    }
  }

  // ---- Where a point should go
  void FindMiddles() {
    own_density_.clear();
    for (const Vec2& p : points_) own_density_.push_back(density_[CellOf(p)]);
    middle_.assign(points_.size(), Vec2::Zero());
    weight_.assign(points_.size(), 0);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const int owner = owner_[At(x, y)];
        if (owner == kNone) continue;
        const auto i = static_cast<std::size_t>(owner);
        const double density =
            std::min<double>(density_[At(x, y)], 1.5 * own_density_[i]);
        middle_[i] += density * density * CentreOf(x, y);
        weight_[i] += density * density;
      }
    }
  }

  void Move(std::size_t i) {
    if (!(weight_[i] > 0)) return;
    const Vec2 wanted = middle_[i] / weight_[i] - points_[i];
    for (const double share : {1.0, 0.5, 0.25}) {
      const Vec2 p = points_[i] + share * wanted;
      if ((p - began_[i]).norm() > options_.reach_mm || !IsFree(i, p)) continue;
      Unlink(static_cast<int>(i));
      points_[i] = p;
      Link(static_cast<int>(i));
      return;
    }
  }

  // ---- Points by squares as wide as the spacing
  int Square(double at_mm, int count) const {
    return std::clamp(static_cast<int>(at_mm / options_.spacing_mm), 0, count - 1);
  }
  int& First(const Vec2& p) {
    return first_[static_cast<std::size_t>(Square(p.y(), rows_)) *
                      static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(Square(p.x(), columns_))];
  }
  void Link(int i) {
    int& first = First(points_[static_cast<std::size_t>(i)]);
    following_[static_cast<std::size_t>(i)] = first;
    first = i;
  }
  void Unlink(int i) {
    int* at = &First(points_[static_cast<std::size_t>(i)]);
    while (*at != i) at = &following_[static_cast<std::size_t>(*at)];
    *at = following_[static_cast<std::size_t>(i)];
  }
  bool IsFree(std::size_t i, const Vec2& p) const {
    if ((p.array() < 0).any() || (p.array() >= size_mm_.array()).any()) return false;
    const double smallest = options_.spacing_mm * options_.spacing_mm;
    const int column = Square(p.x(), columns_), row = Square(p.y(), rows_);
    for (int y = std::max(0, row - 1); y <= std::min(rows_ - 1, row + 1); ++y) {
      for (int x = std::max(0, column - 1); x <= std::min(columns_ - 1, column + 1);
           ++x) {
        int other =
            first_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(x)];
        for (; other != kNone; other = following_[static_cast<std::size_t>(other)]) {
          const auto j = static_cast<std::size_t>(other);
          if (j != i && (points_[j] - p).squaredNorm() < smallest) return false;
        }
      }
    }
    return true;
  }

  const SettleOptions& options_;
  PanelPoints& points_;
  const PanelPoints began_;
  const Vec2 size_mm_;
  int width_ = 0, height_ = 0;  // of the raster
  Vec2 cell_mm_;
  std::vector<float> density_;  // of the raster's cells
  std::vector<int> owner_;      // the point nearest to each
  std::vector<float> own_density_;
  PanelPoints middle_;
  std::vector<double> weight_;
  int columns_ = 0, rows_ = 0;  // of the squares
  std::vector<int> first_, following_;
};

}  // namespace

void Settle(const HalftoneGrid& grid, const DensityOf& density,
            const SettleOptions& options, PanelPoints& points) {
  if (options.round_count == 0 || points.empty()) return;
  Settling settling(grid, density, options, points);
  for (int round = 0; round < options.round_count; ++round) settling.Round();
}

}  // namespace intaglio::discretize
