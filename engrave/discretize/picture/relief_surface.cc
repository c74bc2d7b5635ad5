#include "engrave/discretize/picture/relief_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace intaglio::discretize {
namespace {

/// Points of space by their column and row in squares seen from above.
class Squares {
 public:
  Squares(const Box3& bounds, double side_mm) : low_(bounds.min_mm), side_mm_(side_mm) {
    columns_ = static_cast<int>(bounds.size_mm().x() / side_mm) + 1;
    rows_ = static_cast<int>(bounds.size_mm().y() / side_mm) + 1;
    first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                  -1);
  }

  void Add(const Vec3& p) {
    int& first = first_[At(Column(p), Row(p))];
    following_.push_back(first);
    first = static_cast<int>(points_.size());
    points_.push_back(p);
  }

  /// No point is nearer; distance_mm is at most the side.
  bool IsFree(const Vec3& p, double distance_mm) const {
    const double smallest = distance_mm * distance_mm;
    const int column = Column(p), row = Row(p);
    for (int y = std::max(0, row - 1); y <= std::min(rows_ - 1, row + 1); ++y) {
      for (int x = std::max(0, column - 1); x <= std::min(columns_ - 1, column + 1);
           ++x) {
        for (int i = first_[At(x, y)]; i >= 0;
             i = following_[static_cast<std::size_t>(i)]) {
          if ((points_[static_cast<std::size_t>(i)] - p).squaredNorm() < smallest) {
            return false;
          }
        }
      }
    }
    return true;
  }

 private:
  std::size_t At(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x);
  }
  int Column(const Vec3& p) const {
    return std::clamp(static_cast<int>((p.x() - low_.x()) / side_mm_), 0, columns_ - 1);
  }
  int Row(const Vec3& p) const {
    return std::clamp(static_cast<int>((p.y() - low_.y()) / side_mm_), 0, rows_ - 1);
  }

  Vec3 low_;
  double side_mm_;
  int columns_ = 0, rows_ = 0;
  std::vector<int> first_, following_;
  PointList points_;
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double Share() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }  // 0 .. < 1

 private:
  std::mt19937_64 engine_;
};

int SquareCount(double length_mm, double side_mm) {
  return std::max(1, static_cast<int>(std::ceil(length_mm / side_mm)));
}

// Darts: rounds over squares of half a distance. The number thrown in a square is
// proportional to the area of the surface there. 16 rounds are 64 darts per squared
// distance.
constexpr double kSquareRatio = 0.5;
constexpr int kRounds = 16;

}  // namespace

std::vector<float> SurfaceAreas(const ReliefSurface& surface, double side_mm) {
  const int columns = SquareCount(surface.width_mm, side_mm);
  const int rows = SquareCount(surface.height_mm, side_mm);
  std::vector<float> areas;
  areas.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double x = column * side_mm, y = row * side_mm;
      const double z = surface.DepthAt(x, y);
      const double across = (surface.DepthAt(x + side_mm, y) - z) / side_mm;
      const double up = (surface.DepthAt(x, y + side_mm) - z) / side_mm;
      areas.push_back(static_cast<float>(side_mm * side_mm *
                                         std::sqrt(1 + across * across + up * up)));
    }
  }
  return areas;
}

std::vector<PointList> SpreadPoints(const ReliefSurface& surface, double distance_mm,
                                    int layer_count, double layer_distance_mm,
                                    std::uint64_t seed) {
  const double side_mm = kSquareRatio * distance_mm;
  const std::vector<float> areas = SurfaceAreas(surface, side_mm);
  const int columns = SquareCount(surface.width_mm, side_mm);
  Box3 bounds;
  bounds.Extend(Vec3::Zero());
  bounds.Extend(Vec3(surface.width_mm, surface.height_mm, 0));
  Squares squares(bounds, distance_mm);
  Random random(seed);
  std::vector<PointList> layers(static_cast<std::size_t>(layer_count));
  for (int round = 0; round < kRounds * layer_count; ++round) {
    const int layer = round % layer_count;
    for (std::size_t i = 0; i < areas.size(); ++i) {
      const double darts = static_cast<double>(areas[i]) / (side_mm * side_mm);
      const int count = static_cast<int>(darts + random.Share());
      for (int dart = 0; dart < count; ++dart) {
        const int column = static_cast<int>(i) % columns;
        const int row = static_cast<int>(i) / columns;
        const double x = (column + random.Share()) * side_mm;
        const double y = (row + random.Share()) * side_mm;
        if (x >= surface.width_mm || y >= surface.height_mm) continue;
        const Vec3 p(x, y, surface.DepthAt(x, y) + layer * layer_distance_mm);
        if (!squares.IsFree(p, distance_mm)) continue;
        squares.Add(p);
        layers[static_cast<std::size_t>(layer)].push_back(p);
      }
    }
  }
  return layers;
}

/// Points that keep a distance of 2^8 d from each other come first, then those that keep
/// 2^(31/4) d from them and each other, and so on down to d.
std::vector<float> EvenRanks(const PointList& points, double distance_mm,
                             std::uint64_t seed) {
  std::vector<std::size_t> waiting(points.size());
  std::iota(waiting.begin(), waiting.end(), std::size_t{0});
  std::mt19937_64 random(seed);
  for (std::size_t i = waiting.size(); i > 1; --i) {
    std::swap(waiting[i - 1], waiting[random() % i]);
  }
  Box3 bounds;
  for (const Vec3& p : points) bounds.Extend(p);
  std::vector<float> ranks(points.size());
  PointList taken;
  for (int level = 32; level >= 0 && !waiting.empty(); --level) {
    const double radius_mm = level == 0 ? 0 : distance_mm * std::exp2(level / 4.0);
    Squares squares(bounds, std::max(radius_mm, distance_mm));
    for (const Vec3& p : taken) squares.Add(p);
    std::vector<std::size_t> left;
    for (const std::size_t i : waiting) {
      if (!squares.IsFree(points[i], radius_mm)) {
        left.push_back(i);
        continue;
      }
      squares.Add(points[i]);
      ranks[i] = static_cast<float>((static_cast<double>(taken.size()) + 0.5) /
                                    static_cast<double>(points.size()));
      taken.push_back(points[i]);
    }
    waiting = std::move(left);
  }
  return ranks;
}

}  // namespace intaglio::discretize
