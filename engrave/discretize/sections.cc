#include "engrave/discretize/sections.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engrave/core/check.h"
#include "engrave/discretize/candidate_limit.h"
#include "engrave/discretize/contour_points.h"
#include "engrave/discretize/edge_neighbours.h"

// In the frame (u, v, w) of the planes a vertex is above plane h if w >= h, else below. A
// triangle that has both is entered by one edge and left by another; its neighbour across
// an edge is cut, too, in the very same point. So a contour is walked from triangle to
// triangle until it comes back or meets an open edge. Each plane knows its triangles from
// a table (plane -> triangles) whose size is the number of crossings.

namespace intaglio::discretize {
namespace {

// A face whose normal is this near to the planes' is parallel to them: 0.1 degrees.
constexpr double kParallelCosine = 0.9999985;

class Slicer {
 public:
  Slicer(const mesh::TriangleMesh& mesh, const SectionOptions& options)
      : mesh_(mesh), options_(options), neighbours_(EdgeNeighbours(mesh)) {
    const Mat3 frame = FrameOf(options.normal);
    normal_ = frame.col(2);
    height_.reserve(mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) height_.push_back(v.dot(normal_));
    visited_.assign(mesh.triangles.size(), 0);
  }

  /// To be called first.
  Status ChoosePlanes();
  void FillTable();

  std::size_t plane_count() const { return planes_.size(); }
  double ParallelArea() const;
  /// The points of one plane.
  void Cut(std::size_t plane, MethodStatistics& statistics, PointList& points);

 private:
  std::pair<std::size_t, std::size_t> PlanesOf(const mesh::Triangle& triangle) const;
  bool Above(std::uint32_t vertex, double h) const { return height_[vertex] >= h; }
  std::uint32_t OtherCutSide(std::uint32_t half_edge, double h) const;
  std::uint32_t FirstCutSide(std::uint32_t triangle, double h) const;
  Vec3 CrossingOf(std::uint32_t half_edge, double h) const;
  bool Walk(std::uint32_t half_edge, double h, std::uint32_t stamp, PointList& contour);

  const mesh::TriangleMesh& mesh_;
  const SectionOptions& options_;
  std::vector<std::uint32_t> neighbours_;
  Vec3 normal_;
  std::vector<double> height_;            // of the vertices, along the normal
  std::vector<double> planes_;            // heights, rising
  std::vector<std::size_t> table_begin_;  // of each plane in table_
  std::vector<std::uint32_t> table_;      // triangles
  std::vector<std::uint32_t> visited_;    // newest plane + 1 that visited a triangle
};

Status Slicer::ChoosePlanes() {
  const auto [low, high] = std::minmax_element(height_.begin(), height_.end());
  if (low == height_.end()) return {};
  const double inset = options_.first_last_distance_ratio * options_.layer_distance_mm;
  const double first = *low + inset, last = *high - inset;
  if (last < first) {
    planes_.push_back(0.5 * (*low + *high));
    return {};
  }
  // The last plane that fits is not lost to rounding of the division.
  const double fitting = std::floor((last - first) / options_.layer_distance_mm + 1e-9);
  if (Status few = CheckCandidateCount(fitting); !few) return few;
  const auto count = static_cast<std::size_t>(fitting) + 1;
  for (std::size_t k = 0; k < count; ++k) {
    planes_.push_back(first + static_cast<double>(k) * options_.layer_distance_mm *
                                  kRoundingAllowance);
  }
  return {};
}

// The planes h with lowest < h <= highest vertex: there are vertices on both sides.
std::pair<std::size_t, std::size_t> Slicer::PlanesOf(
    const mesh::Triangle& triangle) const {
  const auto [low, high] =
      std::minmax({height_[triangle[0]], height_[triangle[1]], height_[triangle[2]]});
  const auto begin = std::upper_bound(planes_.begin(), planes_.end(), low);
  const auto end = std::upper_bound(begin, planes_.end(), high);
  return {static_cast<std::size_t>(begin - planes_.begin()),
          static_cast<std::size_t>(end - planes_.begin())};
}

void Slicer::FillTable() {
  table_begin_.assign(planes_.size() + 1, 0);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges;
  ranges.reserve(mesh_.triangles.size());
  for (const mesh::Triangle& triangle : mesh_.triangles) {
    const auto [begin, end] = PlanesOf(triangle);
    ranges.emplace_back(begin, end);
    for (std::size_t k = begin; k < end; ++k) ++table_begin_[k + 1];
  }
  std::partial_sum(table_begin_.begin(), table_begin_.end(), table_begin_.begin());
  table_.resize(table_begin_.back());
  std::vector<std::size_t> next(table_begin_.begin(), table_begin_.end() - 1);
  for (std::uint32_t t = 0; t < ranges.size(); ++t) {
    for (std::size_t k = ranges[t].first; k < ranges[t].second; ++k)
      table_[next[k]++] = t;
  }
}

double Slicer::ParallelArea() const {
  double area = 0;
  for (const mesh::Triangle& t : mesh_.triangles) {
    const Vec3 cross = (mesh_.vertices[t[1]] - mesh_.vertices[t[0]])
                           .cross(mesh_.vertices[t[2]] - mesh_.vertices[t[0]]);
    if (std::abs(cross.dot(normal_)) >= kParallelCosine * cross.norm())
      area += cross.norm() / 2;
  }
  return area;
}

std::uint32_t Slicer::FirstCutSide(std::uint32_t triangle, double h) const {
  const mesh::Triangle& t = mesh_.triangles[triangle];
  std::uint32_t side = 0;
  while (Above(t[side], h) == Above(t[(side + 1) % 3], h)) ++side;
  return 3 * triangle + side;
}

std::uint32_t Slicer::OtherCutSide(std::uint32_t half_edge, double h) const {
  const std::uint32_t triangle = half_edge / 3;
  const mesh::Triangle& t = mesh_.triangles[triangle];
  for (std::uint32_t turn = 1; turn < 3; ++turn) {
    const std::uint32_t side = (half_edge % 3 + turn) % 3;
    if (Above(t[side], h) != Above(t[(side + 1) % 3], h)) return 3 * triangle + side;
  }
  throw PreconditionError("a triangle is entered by a plane and not left");
}

// From the lower-numbered vertex, so that both triangles of an edge get the same bits.
Vec3 Slicer::CrossingOf(std::uint32_t half_edge, double h) const {
  const mesh::Triangle& t = mesh_.triangles[half_edge / 3];
  std::uint32_t a = t[half_edge % 3], b = t[(half_edge % 3 + 1) % 3];
  if (a > b) std::swap(a, b);
  const double part = (h - height_[a]) / (height_[b] - height_[a]);
  return mesh_.vertices[a] + part * (mesh_.vertices[b] - mesh_.vertices[a]);
}

// From the triangle of `half_edge`, which was entered by it, on; true when it came back.
bool Slicer::Walk(std::uint32_t half_edge, double h, std::uint32_t stamp,
                  PointList& contour) {
  for (;;) {
    visited_[half_edge / 3] = stamp;
    const std::uint32_t out = OtherCutSide(half_edge, h);
    contour.push_back(CrossingOf(out, h));
    const std::uint32_t across = neighbours_[out];
    if (across == kNoNeighbour) return false;
    if (visited_[across / 3] == stamp) return true;
    half_edge = across;
  }
}

void Slicer::Cut(std::size_t plane, MethodStatistics& statistics, PointList& points) {
  const double h = planes_[plane];
  const auto stamp = static_cast<std::uint32_t>(plane + 1);
  ContourSpacing spacing;
  spacing.distance_mm = options_.vertex_distance_mm;
  spacing.insert_end_points = options_.insert_end_points;
  const double twist = options_.twist_phase_ratio * static_cast<double>(plane);
  spacing.phase_ratio = twist - std::floor(twist);
  PointList contour, back;
  for (std::size_t i = table_begin_[plane]; i < table_begin_[plane + 1]; ++i) {
    const std::uint32_t triangle = table_[i];
    if (visited_[triangle] == stamp) continue;
    const std::uint32_t entry = FirstCutSide(triangle, h);
    contour.clear();
    const bool closed = Walk(entry, h, stamp, contour);
    if (!closed) {
      // It met an open edge; the other half lies behind the entry.
      back.assign(1, CrossingOf(entry, h));
      const std::uint32_t behind = neighbours_[entry];
      if (behind != kNoNeighbour && visited_[behind / 3] != stamp)
        Walk(behind, h, stamp, back);
      std::reverse(back.begin(), back.end());
      contour.insert(contour.begin(), back.begin(), back.end());
    }
    ++(closed ? statistics.closed_contour_count : statistics.open_contour_count);
    AddContourPoints(contour, closed, spacing, points);
  }
}

}  // namespace

Result<MethodStatistics> CutSections(const mesh::TriangleMesh& mesh,
                                     const SectionOptions& options, std::uint32_t source,
                                     const ProgressSink& progress, PointCloud& cloud) {
  Require(options.layer_distance_mm > 0 && options.vertex_distance_mm > 0,
          "layer and vertex distance must be positive, are {} and {}",
          options.layer_distance_mm, options.vertex_distance_mm);
  Slicer slicer(mesh, options);
  if (const Status few = slicer.ChoosePlanes(); !few) return tl::unexpected(few.error());
  slicer.FillTable();
  MethodStatistics statistics;
  statistics.plane_count = slicer.plane_count();
  statistics.parallel_area_mm2 = slicer.ParallelArea();
  const std::size_t before = cloud.size();
  for (std::size_t plane = 0; plane < slicer.plane_count(); ++plane) {
    if (progress && !progress(plane, slicer.plane_count())) {
      return Fail(ErrorCode::kCancelled, "cutting sections was cancelled");
    }
    slicer.Cut(plane, statistics, cloud.points_mm);
    cloud.source.resize(cloud.points_mm.size(), source);
    const Status few = CheckCandidateCount(static_cast<double>(cloud.size()));
    if (!few) return tl::unexpected(few.error());
  }
  statistics.point_count = cloud.size() - before;
  return statistics;
}

}  // namespace intaglio::discretize
