#include "engrave/discretize/mesh/rays.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/discretize/mesh/ray_caster.h"
#include "engrave/discretize/spacing/candidate_limit.h"
#include "engrave/discretize/spacing/interval_index.h"

namespace intaglio::discretize {
namespace {

// A crossing is computed in another frame than that of its triangle: it lies within the
// triangle's heights except for rounding.
constexpr double kRoundingMm = 1e-6;
// Space reserved for crossings, as a ratio of the expected number.
constexpr double kRoomRatio = 1.05;

void CountRay(std::size_t crossings, MethodStatistics& statistics) {
  ++statistics.ray_count;
  statistics.odd_ray_count += crossings % 2;
}

Status CastingCancelled() {
  return Fail(ErrorCode::kCancelled, "casting rays was cancelled");
}

/// Appends points to a list without checking its capacity for each one.
class PointsBehind {
 public:
  PointsBehind(PointList& points, std::size_t expected)
      : points_(points), count_(points.size()) {
    points_.resize(count_ + expected);
  }
  ~PointsBehind() { points_.resize(count_); }

  /// Returns the place where `more` points can be written.
  Vec3* Room(std::size_t more) {
    if (points_.size() - count_ < more) points_.resize(2 * (count_ + more));
    return points_.data() + count_;
  }
  void KeepUntil(const Vec3* end) {
    count_ = static_cast<std::size_t>(end - points_.data());
  }

 private:
  PointList& points_;
  std::size_t count_;
};

/// Which triangles reach into a range of heights.
class TriangleHeights {
 public:
  TriangleHeights(const mesh::TriangleMesh& mesh, const Box3& bounds)
      : low_mm_(bounds.min_mm.z()),
        cells_per_mm_(kCells / std::max(bounds.size_mm().z(), kRoundingMm)),
        index_(ReachOf(mesh)) {}

  std::vector<IndexedInterval> Reaching(const HeightRange& range) const {
    std::vector<IndexedInterval> found;
    index_.Find({CellOf(range.low_mm), CellOf(range.high_mm) + 1}, found);
    return found;
  }

 private:
  static constexpr double kCells = 0x1p16;

  std::uint32_t CellOf(double z_mm) const {
    return static_cast<std::uint32_t>(
        std::clamp((z_mm - low_mm_) * cells_per_mm_ + 1, 0.0, kCells + 2));
  }
  std::vector<Interval> ReachOf(const mesh::TriangleMesh& mesh) const {
    std::vector<Interval> reach;
    reach.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      const auto [low, high] =
          std::minmax({mesh.vertices[a].z(), mesh.vertices[b].z(), mesh.vertices[c].z()});
      reach.push_back({CellOf(low - kRoundingMm), CellOf(high + kRoundingMm) + 1});
    }
    return reach;
  }

  double low_mm_, cells_per_mm_;
  IntervalIndex index_;
};

PointList InFrame(const PointList& points, const Mat3& frame) {
  PointList turned;
  turned.reserve(points.size());
  const Mat3 inverse = frame.transpose();
  for (const Vec3& p : points) turned.emplace_back(inverse * p);
  return turned;
}

class RaySource : public PointSource {
 public:
  /// The second are the mesh's vertices in the rays' frame.
  RaySource(mesh::TriangleMesh mesh, const PointList& vertices, const RayGrid& grid,
            const Mat3& frame)
      : frame_(frame),
        mesh_(std::move(mesh)),
        bounds_(mesh_.Bounds()),
        caster_(grid, vertices) {}

  Box3 Bounds() const override { return bounds_; }

 protected:
  /// Where a ray has the height 0.
  Vec3 OriginOf(std::uint32_t column, std::uint32_t row) const {
    const RayGrid& grid = caster_.grid();
    return frame_.col(1) * grid.V(row) + frame_.col(0) * grid.U(column);
  }
  const RayCaster& caster() const { return caster_; }
  Vec3 direction() const { return frame_.col(2); }
  const std::vector<mesh::Triangle>& triangles() const { return mesh_.triangles; }
  std::vector<mesh::Triangle> TrianglesIn(const HeightRange& range) const {
    std::call_once(sorted_, [this] { heights_.emplace(mesh_, bounds_); });
    std::vector<mesh::Triangle> reaching;
    for (const IndexedInterval& found : heights_->Reaching(range)) {
      reaching.push_back(mesh_.triangles[found.item]);
    }
    return reaching;
  }
  bool HoldsAll(const HeightRange& range) const {
    return range.low_mm < bounds_.min_mm.z() - kRoundingMm &&
           range.high_mm > bounds_.max_mm.z() + kRoundingMm;
  }
  bool HoldsLowest(const HeightRange& range) const {
    return range.Contains(bounds_.min_mm.z());
  }

 private:
  Mat3 frame_;
  mesh::TriangleMesh mesh_;
  Box3 bounds_;
  RayCaster caster_;
  mutable std::once_flag sorted_;  // when the first range of heights is requested
  mutable std::optional<TriangleHeights> heights_;
};

class Crossings final : public RaySource {
 public:
  using RaySource::RaySource;

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override {
    if (progress && !progress(0, 1)) return tl::unexpected(CastingCancelled().error());
    const bool all = HoldsAll(range);
    MethodStatistics statistics;
    if (HoldsLowest(range) && !all) {
      // The rays of the lowest range cross everything above it as well.
      const Status cast = caster().Cast(
          triangles(), [&](std::uint32_t, std::uint32_t, std::span<const double> ray) {
            CountRay(ray.size(), statistics);
          });
      if (!cast) return tl::unexpected(cast.error());
    }
    std::vector<mesh::Triangle> part;
    if (!all) part = TrianglesIn(range);
    const std::size_t before = cloud.size();
    INTAGLIO_TRY(AddCrossings(all ? triangles() : part, range, cloud.points_mm,
                              all ? &statistics : nullptr));
    const std::size_t count = cloud.size();
    cloud.source.resize(count, source);
    cloud.spacing_mm.resize(count, 0);
    statistics.point_count = count - before;
    return statistics;
  }

 private:
  /// Counts the rays when `statistics` is given.
  Status AddCrossings(std::span<const mesh::Triangle> triangles, const HeightRange& range,
                      PointList& points_mm, MethodStatistics* statistics) const {
    const double about = caster().CrossingsAbout(triangles);
    INTAGLIO_TRY(CheckCandidateCount(about));
    PointsBehind points(points_mm, static_cast<std::size_t>(about * kRoomRatio));
    const Vec3 direction = this->direction();
    return caster().Cast(triangles, [&](std::uint32_t column, std::uint32_t row,
                                        std::span<const double> ray) {
      if (statistics != nullptr) CountRay(ray.size(), *statistics);
      const Vec3 origin = OriginOf(column, row);
      Vec3* to = points.Room(ray.size());
      for (const double w_mm : ray) {
        *to = origin + direction * w_mm;
        to += range.Contains(to->z()) ? 1 : 0;
      }
      points.KeepUntil(to);
    });
  }
};

class Insides final : public RaySource {
 public:
  using RaySource::RaySource;

  /// To be called first.
  Status FindWays(double distance_mm) {
    return caster().Cast(triangles(), [&](std::uint32_t column, std::uint32_t row,
                                          std::span<const double> ray) {
      CountRay(ray.size(), statistics_);
      if (ray.size() % 2 != 0) return;
      for (std::size_t i = 0; i < ray.size(); i += 2) {
        const double length_mm = ray[i + 1] - ray[i];
        const double parts = std::floor(length_mm / (distance_mm * kRoundingAllowance));
        if (parts < 2) continue;
        ways_.push_back({column, row, ray[i], length_mm / parts, parts - 1});
      }
    });
  }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override {
    const std::size_t before = cloud.size();
    MethodStatistics statistics;
    if (HoldsLowest(range)) statistics = statistics_;
    for (std::size_t i = 0; i < ways_.size(); ++i) {
      if (progress && i % 4096 == 0 && !progress(i, ways_.size())) {
        return tl::unexpected(CastingCancelled().error());
      }
      const auto [first, last] = StepsIn(ways_[i], range);
      INTAGLIO_TRY(CheckCandidateCount(static_cast<double>(cloud.size()) + last - first));
      for (double step = first; step <= last; ++step) {
        const Vec3 p = PointOf(ways_[i], step);
        if (range.Contains(p.z())) cloud.Add(p, source);
      }
    }
    statistics.point_count = cloud.size() - before;
    return statistics;
  }

 private:
  /// From an entry to its exit; points at steps 1 to count.
  struct Way {
    std::uint32_t column, row;
    double entry_mm, step_mm, count;
  };

  Vec3 PointOf(const Way& way, double step) const {
    return OriginOf(way.column, way.row) +
           direction() * (way.entry_mm + step * way.step_mm);
  }
  /// At least those steps whose points lie in the range.
  std::pair<double, double> StepsIn(const Way& way, const HeightRange& range) const {
    const double z_mm = PointOf(way, 0).z();
    const double step_z_mm = (PointOf(way, way.count).z() - z_mm) / way.count;
    if (std::abs(step_z_mm) < kRoundingMm) return {1, way.count};
    double first = (range.low_mm - z_mm) / step_z_mm;
    double last = (range.high_mm - z_mm) / step_z_mm;
    if (first > last) std::swap(first, last);
    return {std::max(1.0, std::floor(first) - 1),
            std::min(way.count, std::ceil(last) + 1)};
  }

  std::vector<Way> ways_;
  MethodStatistics statistics_;
};

}  // namespace

Result<std::unique_ptr<PointSource>> MakeRays(mesh::TriangleMesh mesh,
                                              const RayOptions& options) {
  Require(options.distance_mm > 0, "distance_mm must be positive, is {}",
          options.distance_mm);
  const Mat3 frame = options.axes * FrameOf(options.direction);
  const PointList vertices = InFrame(mesh.vertices, frame);
  Box3 bounds;
  for (const Vec3& v : vertices) bounds.Extend(v);
  if (bounds.empty()) bounds.Extend(Vec3(0, 0, 0));
  const double step_mm = options.distance_mm * kRoundingAllowance;
  const RayGrid grid =
      INTAGLIO_TRY(options.grid_through_origin ? GridThroughOrigin(bounds, step_mm)
                                               : GridOver(bounds, step_mm, step_mm));
  if (!options.interior_only) {
    return std::make_unique<Crossings>(std::move(mesh), vertices, grid, frame);
  }
  auto insides = std::make_unique<Insides>(std::move(mesh), vertices, grid, frame);
  INTAGLIO_TRY(insides->FindWays(options.distance_mm));
  return insides;
}

}  // namespace intaglio::discretize
