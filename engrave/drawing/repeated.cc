#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/segment.h"
#include "engrave/curve/cell.h"
#include "engrave/drawing/flatten.h"

// Curves that run along each other have the same bounding box: boxes are found in a grid
// of their six numbers. The remaining pairs are compared by the distances of some points
// of each curve from the other.

namespace intaglio::drawing {
namespace {

// A box lies within the tolerance of another cell in one of sixteen numbers only.
constexpr double kCellTolerances = 64;
constexpr std::size_t kMaxAlike = 16;
constexpr std::size_t kSamples = 32;
// Lengths of two flattenings differ by far less.
constexpr double kLengthRatio = 0.01;
// Distances from a segment, about 5 ns each.
constexpr std::uint64_t kMaxDistances = 100'000'000;

using BoxCell = curve::Cell<6>;

struct Shape {
  std::array<double, 6> box{};
  double length_mm = 0;
};

Shape ShapeOf(const FlatCurve& curve) {
  Vec3 low = curve.points_mm.front(), high = low, last = curve.points_mm.back();
  Shape shape;
  for (const Vec3& p : curve.points_mm) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    shape.length_mm += (p - last).norm();
    last = p;
  }
  shape.box = {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
  return shape;
}

class Repeated {
 public:
  explicit Repeated(double tolerance_mm) : tolerance_mm_(tolerance_mm) {}

  /// Whether the curve runs along one that was kept; else it is kept.
  bool Is(const FlatCurve& curve, std::vector<FlatCurve>& kept) {
    if (!curve.closed || curve.points_mm.size() < 2) return false;
    const Shape shape = ShapeOf(curve);
    const double cell_mm = kCellTolerances * tolerance_mm_;
    BoxCell home{}, other{};
    std::size_t straddled = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      // Far from the origin a cell is smaller than the resolution of the number, and its
      // index does not fit an integer.
      const double at = std::clamp(shape.box[i] / cell_mm, -1e15, 1e15);
      home[i] = static_cast<std::int64_t>(std::floor(at));
      other[i] = static_cast<std::int64_t>(
          std::floor(at + (at - std::floor(at) < 0.5 ? -1 : 1) / kCellTolerances));
      if (other[i] != home[i]) straddled |= std::size_t{1} << i;
    }
    for (std::size_t choice = 0; choice < 64; ++choice) {
      if ((choice & ~straddled) != 0) continue;
      BoxCell cell = home;
      for (std::size_t i = 0; i < 6; ++i) {
        if ((choice >> i & 1) != 0) cell[i] = other[i];
      }
      if (IsIn(cell, curve, shape, kept)) return true;
    }
    auto& alike = by_cell_[home];
    if (alike.size() < kMaxAlike) alike.emplace_back(kept.size(), shape);
    return false;
  }

 private:
  bool IsIn(const BoxCell& cell, const FlatCurve& curve, const Shape& shape,
            const std::vector<FlatCurve>& kept) {
    const auto found = by_cell_.find(cell);
    if (found == by_cell_.end()) return false;
    return std::ranges::any_of(found->second, [&](const auto& alike) {
      const auto& [index, other] = alike;
      for (std::size_t i = 0; i < 6; ++i) {
        if (std::abs(shape.box[i] - other.box[i]) > tolerance_mm_) return false;
      }
      return std::abs(shape.length_mm - other.length_mm) <=
                 tolerance_mm_ + kLengthRatio * shape.length_mm &&
             RunsAlong(curve, kept[index]) && RunsAlong(kept[index], curve);
    });
  }

  /// Whether points of p, spread over it, lie on q.
  bool RunsAlong(const FlatCurve& p, const FlatCurve& q) {
    const std::size_t count = std::min(kSamples, p.points_mm.size());
    for (std::size_t i = 0; i < count; ++i) {
      distances_ += q.points_mm.size();
      if (distances_ > kMaxDistances) return false;
      if (!LiesOn(p.points_mm[i * p.points_mm.size() / count], q)) return false;
    }
    return true;
  }
  bool LiesOn(const Vec3& point, const FlatCurve& curve) const {
    const double largest = tolerance_mm_ * tolerance_mm_;
    const PointList& points = curve.points_mm;
    const Vec3* last = &points.back();
    for (const Vec3& next : points) {
      if (SquaredDistanceFromSegment(point, *last, next) <= largest) return true;
      last = &next;
    }
    return false;
  }

  double tolerance_mm_;
  std::uint64_t distances_ = 0;
  std::unordered_map<BoxCell, std::vector<std::pair<std::size_t, Shape>>, curve::CellHash>
      by_cell_;
};

}  // namespace

void RemoveRepeatedContours(double tolerance_mm, FlatDrawing& flat) {
  Require(tolerance_mm > 0, "tolerance_mm must be positive, is {}", tolerance_mm);
  Repeated repeated(tolerance_mm);
  std::vector<FlatCurve> kept;
  for (FlatCurve& curve : flat.curves) {
    if (!repeated.Is(curve, kept)) kept.push_back(std::move(curve));
  }
  flat.curves = std::move(kept);
}

}  // namespace intaglio::drawing
