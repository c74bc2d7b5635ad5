#include "engrave/discretize/mesh/surface_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/discretize/mesh/own_points.h"
#include "engrave/discretize/mesh/surface_lattice.h"
#include "engrave/discretize/spacing/candidate_limit.h"

// How far a place can be from the nearest candidate. Within triangles of one direction
// the lattice's nodes are its step apart, stretched along the slope by at most 1 / cos 28
// degrees = 1.13, so 0.65 steps; at a border between directions the nodes of one side end
// within that, and those of the other begin. Along narrow triangles the edges' points are
// a step apart, in cubes of a step.

namespace intaglio::discretize {
namespace {

constexpr std::uint64_t kTrianglesPerReport = 8192;
// Twice the area by the square of the longest edge: below it a normal is meaningless, and
// the triangle is so close to its edges that its neighbours cover it.
constexpr double kMinAreaRatio = 1e-10;
// Narrow: height by longest edge, and height in steps.
constexpr double kNarrowRatio = 0.25, kNarrowSteps = 1;
// Layers of the index of heights, at most.
constexpr double kMaxLayers = 1 << 20;

Corners CornersOf(const mesh::TriangleMesh& mesh, std::uint32_t triangle) {
  const mesh::Triangle& t = mesh.triangles[triangle];
  return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

double LongestOf(const Corners& c) {
  return std::sqrt(std::max({(c[1] - c[0]).squaredNorm(), (c[2] - c[1]).squaredNorm(),
                             (c[0] - c[2]).squaredNorm()}));
}

/// About how much of the triangle lies in the range.
double ShareOf(const HeightRange& range, const Corners& c) {
  const auto [low, high] = std::minmax({c[0].z(), c[1].z(), c[2].z()});
  const double within = std::min(high, range.high_mm) - std::max(low, range.low_mm);
  if (high == low) return range.Contains(low) ? 1 : 0;
  return std::clamp(within / (high - low), 0.0, 1.0);
}

int LevelOf(std::int64_t i, std::int64_t j) {
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(i | j));
  return std::min(zeros, SurfaceGrid::kMaxLevel);
}

}  // namespace

SurfaceGrid::SurfaceGrid(const mesh::TriangleMesh& mesh,
                         const SurfaceGridOptions& options)
    : mesh_(mesh), options_(options), by_height_(std::span<const Interval>{}) {
  Require(options.step_mm > 0, "step_mm must be positive, is {}", options.step_mm);
  for (const mesh::Triangle& t : mesh.triangles) {
    for (const std::uint32_t corner : t) bounds_.Extend(mesh.vertices[corner]);
  }
  const double height_mm = bounds_.size_mm().z();
  heights_per_mm_ = 1 / std::max({options.step_mm, height_mm / kMaxLayers});
  std::vector<Interval> intervals;
  intervals.reserve(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Corners c = CornersOf(mesh, t);
    const auto [low, high] = std::minmax({c[0].z(), c[1].z(), c[2].z()});
    intervals.push_back(HeightsOf(low, high));
  }
  by_height_ = IntervalIndex(intervals);
  if (options.own_points) FindFirstCorners();
}

void SurfaceGrid::FindFirstCorners() {
  std::vector<bool> seen(mesh_.vertices.size(), false);
  first_corners_.assign(mesh_.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    for (unsigned i = 0; i < 3; ++i) {
      const std::uint32_t vertex = mesh_.triangles[t][i];
      if (!seen[vertex]) first_corners_[t] |= static_cast<std::uint8_t>(1U << i);
      seen[vertex] = true;
    }
  }
}

Interval SurfaceGrid::HeightsOf(double low_mm, double high_mm) const {
  const double base_mm = bounds_.min_mm.z();
  const auto layer = [&](double z_mm) {
    return static_cast<std::uint32_t>(
        std::clamp((z_mm - base_mm) * heights_per_mm_, 0.0, kMaxLayers));
  };
  return {layer(low_mm), layer(high_mm) + 1};
}

/// The work of a call of ForEach, triangle by triangle.
class SurfaceGrid::Walk {
 public:
  Walk(const SurfaceGrid& grid, const HeightRange& range, const Visitor& visit)
      : mesh_(grid.mesh_),
        options_(grid.options_),
        range_(range),
        visit_(visit),
        first_corners_(grid.first_corners_),
        own_(grid.options_.step_mm),
        wider_(own_.WholeCubes(range)) {}

  /// The range of triangles that matter: cubes reach out of the other.
  const HeightRange& wider() const { return wider_; }

  Status Triangle(std::uint32_t triangle) {
    const double step_mm = options_.step_mm;
    const Corners c = CornersOf(mesh_, triangle);
    const double longest_mm = LongestOf(c);
    const Vec3 normal = (c[1] - c[0]).cross(c[2] - c[0]);
    const double doubled_area = normal.norm();
    const bool flat = !(doubled_area > kMinAreaRatio * longest_mm * longest_mm);
    if (range_.Contains(std::min({c[0].z(), c[1].z(), c[2].z()}))) {
      statistics_.small_triangle_count += !flat && longest_mm < step_mm ? 1 : 0;
      statistics_.rejected_triangle_count += flat ? 1 : 0;
    }
    const Status few = Fits(ShareOf(range_, c) * doubled_area / (step_mm * step_mm));
    if (!few) return few;
    if (options_.own_points) {
      const bool narrow = doubled_area / longest_mm <
                          std::max(kNarrowSteps * step_mm, kNarrowRatio * longest_mm);
      const unsigned first = first_corners_[triangle];
      AddCorners(c, {(first & 1) != 0, (first & 2) != 0, (first & 4) != 0}, wider_,
                 triangle, own_);
      if (narrow || options_.all_edges) AddEdges(c, step_mm, wider_, triangle, own_);
    }
    if (flat) return {};
    ForEachNode(c, normal, FrameFor(normal), step_mm, range_,
                [&](const Vec3& p, std::int64_t i, std::int64_t j) {
                  Visit({p, triangle, LevelOf(i, j)});
                });
    return {};
  }

  Status OwnPoints() {
    INTAGLIO_TRY(Fits(static_cast<double>(own_.points().size())));
    for (const OnePerCube::Point& own : own_.points()) {
      if (range_.Contains(own.p_mm.z())) Visit({own.p_mm, own.triangle, kMaxLevel});
    }
    return {};
  }

  const MethodStatistics& statistics() const { return statistics_; }

 private:
  Status Fits(double more) const {
    return CheckCandidateCount(static_cast<double>(statistics_.point_count) + more);
  }
  void Visit(const SurfacePoint& point) {
    ++statistics_.point_count;
    visit_(point);
  }

  const mesh::TriangleMesh& mesh_;
  const SurfaceGridOptions& options_;
  HeightRange range_;
  const Visitor& visit_;
  const std::vector<std::uint8_t>& first_corners_;
  OnePerCube own_;
  HeightRange wider_;
  MethodStatistics statistics_;
};

Result<MethodStatistics> SurfaceGrid::ForEach(const HeightRange& range,
                                              const ProgressSink& progress,
                                              const Visitor& visit) const {
  if (bounds_.empty() || !(range.low_mm < range.high_mm)) return MethodStatistics{};
  Walk walk(*this, range, visit);
  std::vector<IndexedInterval> found;
  by_height_.Find(HeightsOf(walk.wider().low_mm, walk.wider().high_mm), found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i % kTrianglesPerReport == 0 && progress && !progress(i, found.size())) {
      return Fail(ErrorCode::kCancelled, "making the points of a surface was cancelled");
    }
    INTAGLIO_TRY(walk.Triangle(found[i].item));
  }
  INTAGLIO_TRY(walk.OwnPoints());
  return walk.statistics();
}

}  // namespace intaglio::discretize
