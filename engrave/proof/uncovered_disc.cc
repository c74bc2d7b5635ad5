#include "engrave/proof/uncovered_disc.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

// Let f(x) be the distance from x to the nearest point. On a triangle with the middle c
// and corners v, f is bounded by
//   f(x) <= f(c) + R,  R = max |c - v|         (f changes no faster than x moves)
//   f(x) <= max |p - v| for any point p        (|x - p| is convex)
// A triangle whose bound does not exceed the maximum found so far is discarded. The
// others are halved until few points can be the nearest of any of their places: those
// with |p - c| <= R + the bound. Then the triangle is cut into the parts that are nearest
// to each of them (the cells of Voronoi 1908): on such a part f = |x - p| is convex, and
// so largest at one of its corners. Triangles are processed in rounds, those with the
// largest bounds first. The maximum found in a round is used from the next round on, so
// that the result does not depend on the distribution of the work over threads.

namespace intaglio::proof {
namespace {

constexpr std::size_t kMaxGathered = 160;  // worth keeping for the halves
constexpr std::size_t kMaxCells = 12;      // worth cutting into cells
// A cut adds one corner; rounding that adds another finds room, too.
constexpr std::size_t kMaxPolygon = 2 * kMaxCells + 8;
constexpr std::size_t kFirstRound = 256;
constexpr std::size_t kTrianglesPerTask = 64;
constexpr std::size_t kBoundsPerTask = 4096;
constexpr double kSmallest = 1e-3;  // of f(c): below it a bound is good enough

class Search {
 public:
  Search(const PointTree& tree, const PointList& points_mm, double found_mm)
      : tree_(tree), points_mm_(points_mm) {
    best_.radius_mm = best_.upper_bound_mm = found_mm;
  }

  void Visit(const Corners& triangle) { Visit(triangle, {}); }
  const UncoveredDisc& best() const { return best_; }

 private:
  using Indices = std::vector<std::uint32_t>;

  struct Middle {
    Vec3 at_mm;
    double reach_mm;      // to the farthest corner
    double nearest_mm;    // f there
    std::uint32_t point;  // that is the nearest
  };

  // `known`: all points that can be nearest to a place of the triangle; empty: not known.
  void Visit(const Corners& triangle, std::span<const std::uint32_t> known) {
    const Middle middle = MiddleOf(triangle, known);
    Offer(middle.at_mm, middle.nearest_mm);
    double bound_mm = 0;
    for (const Vec3& corner : triangle) {
      bound_mm = std::max(bound_mm, (corner - points_mm_[middle.point]).norm());
    }
    bound_mm = std::min(bound_mm, middle.nearest_mm + middle.reach_mm);
    if (bound_mm <= best_.radius_mm) return;
    Indices near;
    const bool few = Gather(middle, bound_mm, known, near);
    if (few && near.size() <= kMaxCells) return CutIntoCells(triangle, middle, near);
    if (middle.reach_mm <= kSmallest * middle.nearest_mm) {
      best_.upper_bound_mm = std::max(best_.upper_bound_mm, bound_mm);
      return;
    }
    for (const Corners& half : HalvesOf(triangle)) {
      Visit(half, few ? std::span<const std::uint32_t>(near)
                      : std::span<const std::uint32_t>());
    }
  }

  Middle MiddleOf(const Corners& t, std::span<const std::uint32_t> known) const {
    Middle middle{(t[0] + t[1] + t[2]) / 3, 0, 0, 0};
    for (const Vec3& corner : t) {
      middle.reach_mm = std::max(middle.reach_mm, (corner - middle.at_mm).norm());
    }
    if (known.empty()) {
      const auto nearest = tree_.Nearest(middle.at_mm);
      middle.point = nearest.index;
      middle.nearest_mm = std::sqrt(nearest.square);
      return middle;
    }
    double smallest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : known) {
      const double square = (points_mm_[i] - middle.at_mm).squaredNorm();
      if (square < smallest) {
        smallest = square;
        middle.point = i;
      }
    }
    middle.nearest_mm = std::sqrt(smallest);
    return middle;
  }

  // False when they are too many to keep.
  bool Gather(const Middle& middle, double bound_mm, std::span<const std::uint32_t> known,
              Indices& near) const {
    // A little more: rounding must not lose a point that is only just near enough.
    const double reach_mm = (bound_mm + middle.reach_mm) * (1 + 1e-12);
    const double square = reach_mm * reach_mm;
    if (known.empty()) {
      tree_.ForEachWithin(middle.at_mm, square, [&](std::uint32_t i, double) {
        near.push_back(i);
        return near.size() <= kMaxGathered;
      });
      return near.size() <= kMaxGathered && !near.empty();
    }
    for (const std::uint32_t i : known) {
      if ((points_mm_[i] - middle.at_mm).squaredNorm() <= square) near.push_back(i);
    }
    return !near.empty();
  }

  struct Polygon {
    std::array<Vec3, kMaxPolygon> corners;
    std::size_t count = 0;

    void Add(const Vec3& corner) {
      if (count < corners.size()) corners[count++] = corner;
    }
    double Farthest(const Vec3& p) const {
      double square = 0;
      for (std::size_t i = 0; i < count; ++i) {
        square = std::max(square, (corners[i] - p).squaredNorm());
      }
      return std::sqrt(square);
    }
  };

  /// The part of the polygon that is not farther from p than from q.
  static void KeepNearer(const Vec3& p, const Vec3& q, const Polygon& polygon,
                         Polygon& kept) {
    // |x - q|^2 - |x - p|^2 is linear: 2 (p - q) x + |q|^2 - |p|^2. From their middle it
    // keeps its digits far from the origin.
    const Vec3 towards = p - q, between = 0.5 * (p + q);
    kept.count = 0;
    for (std::size_t i = 0; i < polygon.count; ++i) {
      const Vec3 &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
      const double at_a = towards.dot(a - between), at_b = towards.dot(b - between);
      if (at_a >= 0) kept.Add(a);
      if ((at_a < 0) != (at_b < 0)) kept.Add(a + at_a / (at_a - at_b) * (b - a));
    }
  }

  void CutIntoCells(const Corners& triangle, const Middle& middle, Indices& near) {
    // Points near the middle cut most: the cells of others are empty after a cut or two.
    std::sort(near.begin(), near.end(), [&](std::uint32_t a, std::uint32_t b) {
      return (points_mm_[a] - middle.at_mm).squaredNorm() <
             (points_mm_[b] - middle.at_mm).squaredNorm();
    });
    std::array<Polygon, 2> cells;  // before and after a cut
    for (const std::uint32_t point : near) {
      const Vec3& p = points_mm_[point];
      Polygon *cell = &cells[0], *next = &cells[1];
      cell->count = 0;
      for (const Vec3& corner : triangle) cell->Add(corner);
      for (const std::uint32_t other : near) {
        if (cell->count == 0 || cell->Farthest(p) <= best_.radius_mm) break;
        if (other == point) continue;
        KeepNearer(p, points_mm_[other], *cell, *next);
        std::swap(cell, next);
      }
      for (std::size_t i = 0; i < cell->count; ++i) {
        Offer(cell->corners[i], (cell->corners[i] - p).norm());
      }
    }
  }

  void Offer(const Vec3& place_mm, double radius_mm) {
    if (radius_mm <= best_.radius_mm) return;
    best_.radius_mm = radius_mm;
    best_.place_mm = place_mm;
    best_.upper_bound_mm = std::max(best_.upper_bound_mm, radius_mm);
  }

  const PointTree& tree_;
  const PointList& points_mm_;
  UncoveredDisc best_;
};

/// The bound of a triangle from its corners and its middle.
struct Bound {
  double upper_bound_mm;
  std::uint32_t triangle;
};

std::vector<Bound> BoundsOf(const std::vector<Corners>& triangles, const PointTree& tree,
                            const PointList& points_mm, const Executor& executor,
                            UncoveredDisc& best) {
  std::vector<Bound> bounds(triangles.size());
  std::vector<double> middles_mm(triangles.size());
  const std::size_t tasks = (triangles.size() + kBoundsPerTask - 1) / kBoundsPerTask;
  RunEach(executor, tasks, [&](std::size_t task) {
    const std::size_t end = std::min(triangles.size(), (task + 1) * kBoundsPerTask);
    for (std::size_t i = task * kBoundsPerTask; i < end; ++i) {
      const Corners& t = triangles[i];
      const Vec3 middle = (t[0] + t[1] + t[2]) / 3;
      const auto nearest = tree.Nearest(middle);
      double reach_mm = 0, farthest_mm = 0;
      for (const Vec3& corner : t) {
        reach_mm = std::max(reach_mm, (corner - middle).norm());
        farthest_mm = std::max(farthest_mm, (corner - points_mm[nearest.index]).norm());
      }
      middles_mm[i] = std::sqrt(nearest.square);
      bounds[i] = {std::min(farthest_mm, middles_mm[i] + reach_mm),
                   static_cast<std::uint32_t>(i)};
    }
  });
  const auto largest = std::max_element(middles_mm.begin(), middles_mm.end());
  const Corners& t = triangles[static_cast<std::size_t>(largest - middles_mm.begin())];
  best = {*largest, *largest, (t[0] + t[1] + t[2]) / 3};
  return bounds;
}

}  // namespace

UncoveredDisc LargestUncoveredDisc(const Surface& surface, const PointTree& points,
                                   const PointList& points_mm, const Executor& executor) {
  const std::vector<Corners>& triangles = surface.triangles();
  UncoveredDisc best;
  std::vector<Bound> open = BoundsOf(triangles, points, points_mm, executor, best);
  std::size_t begin = 0;
  for (std::size_t size = kFirstRound; begin < open.size(); size *= 4) {
    // The maximum found in earlier rounds excludes most of the rest.
    open.erase(open.begin(), open.begin() + static_cast<std::ptrdiff_t>(begin));
    std::erase_if(open,
                  [&](const Bound& b) { return b.upper_bound_mm <= best.radius_mm; });
    const std::size_t count = std::min(size, open.size());
    std::partial_sort(open.begin(), open.begin() + static_cast<std::ptrdiff_t>(count),
                      open.end(), [](const Bound& a, const Bound& b) {
                        return a.upper_bound_mm != b.upper_bound_mm
                                   ? a.upper_bound_mm > b.upper_bound_mm
                                   : a.triangle < b.triangle;
                      });
    const std::size_t per_task = size == kFirstRound ? 4 : kTrianglesPerTask;
    std::vector<UncoveredDisc> found((count + per_task - 1) / per_task);
    RunEach(executor, found.size(), [&](std::size_t task) {
      Search search(points, points_mm, best.radius_mm);
      const std::size_t end = std::min(count, (task + 1) * per_task);
      for (std::size_t i = task * per_task; i < end; ++i) {
        search.Visit(triangles[open[i].triangle]);
      }
      found[task] = search.best();
    });
    double upper_bound_mm = best.upper_bound_mm;
    for (const UncoveredDisc& disc : found) {
      upper_bound_mm = std::max(upper_bound_mm, disc.upper_bound_mm);
      if (disc.radius_mm > best.radius_mm) best = disc;
    }
    best.upper_bound_mm = upper_bound_mm;
    begin = count;
  }
  return best;
}

}  // namespace intaglio::proof
