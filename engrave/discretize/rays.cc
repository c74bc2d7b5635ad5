#include "engrave/discretize/rays.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/discretize/candidate_limit.h"

// In the frame (u, v, w) of the rays a triangle is met by ray p if p is on the same side
// of its three edges. The side of edge a -> b is the sign of
//   E = (b - a) x (p - a),
// always computed from the lower-numbered vertex to the higher and turned over where the
// triangle passes the edge the other way, so both triangles of an edge agree. E = 0: the
// ray is moved by (e, e^2) with an infinitesimal e, and the sign is that of -(b_v - a_v),
// or of (b_u - a_u) if that is zero.
//
// So that the sign is exact, u and v of vertices and rays are rounded to multiples of a
// unit of 2^-50 of the model's reach (about 1e-12 mm): their differences are then exact
// in doubles, E is uncertain by the rounding of two products only, and where that matters
// it is computed again with 113 bits, which hold it exactly.
//
// The E of the three edges are the weights with which the corners make up the crossing.

namespace intaglio::discretize {
namespace {

constexpr double kMaxRays = 0x1p27;
constexpr double kMaxRaysPerAxis = 0x1p24;
constexpr std::uint64_t kTrianglesPerReport = 8192;
// Two products and their difference are rounded, by 2^-53 each.
constexpr double kErrorRatio = 0x1p-51;
// A column where E is 0 is computed to better than this, in steps of the grid.
constexpr double kUnsureColumns = 1e-6;
// Weights good to this share of their sum give crossings good to 1e-10 mm.
constexpr double kWeightRatio = 0x1p-36;

struct Grid {
  double unit_mm = 1;                        // of u and v
  double u0_mm = 0, v0_mm = 0, step_mm = 1;  // ray (0, 0); multiples of the unit
  std::int64_t count_u = 0, count_v = 0;

  double Rounded(double mm) const { return std::nearbyint(mm / unit_mm) * unit_mm; }
  double U(std::int64_t i) const { return u0_mm + static_cast<double>(i) * step_mm; }
  double V(std::int64_t j) const { return v0_mm + static_cast<double>(j) * step_mm; }
};

Result<Grid> GridOver(const Box3& bounds, double distance_mm) {
  Grid grid;
  const double reach_mm = std::max({bounds.min_mm.cwiseAbs().maxCoeff(),
                                    bounds.max_mm.cwiseAbs().maxCoeff(), distance_mm});
  grid.unit_mm = std::ldexp(1.0, std::ilogb(reach_mm) - 49);
  grid.step_mm = grid.Rounded(distance_mm * kRoundingAllowance);
  const Vec3 size = bounds.size_mm(), center = bounds.center_mm();
  const double count_u = std::floor(size.x() / grid.step_mm) + 1;
  const double count_v = std::floor(size.y() / grid.step_mm) + 1;
  if (count_u * count_v > kMaxRays || std::max(count_u, count_v) > kMaxRaysPerAxis) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("a grid of {:.3g} rays is too fine for the model; take a "
                            "larger distance than {} mm",
                            count_u * count_v, distance_mm),
                fmt::format("{}", distance_mm));
  }
  grid.count_u = static_cast<std::int64_t>(count_u);
  grid.count_v = static_cast<std::int64_t>(count_v);
  grid.u0_mm = grid.Rounded(center.x() - 0.5 * (count_u - 1) * grid.step_mm);
  grid.v0_mm = grid.Rounded(center.y() - 0.5 * (count_v - 1) * grid.step_mm);
  return grid;
}

/// E of an edge as a function of the ray.
class EdgeFunction {
 public:
  /// From a to b, a being the lower-numbered vertex; `sign` is -1 to turn it over.
  EdgeFunction(const Vec3& a, const Vec3& b, double sign)
      : au_(a.x()), av_(a.y()), du_(b.x() - a.x()), dv_(b.y() - a.y()), sign_(sign) {}

  double Exact(double pu, double pv) const {
    using Wide = __float128;
    const Wide e = Wide(du_) * (pv - av_) - Wide(dv_) * (pu - au_);
    return sign_ * static_cast<double>(e);
  }
  void TurnOver() { sign_ = -sign_; }

  /// E at the ray, of the right sign; `positive` tells it where E is 0, too.
  double At(double pu, double pv, bool& positive) const {
    const double first = du_ * (pv - av_), second = dv_ * (pu - au_);
    double e = sign_ * (first - second);
    if (std::abs(e) <= kErrorRatio * (std::abs(first) + std::abs(second))) {
      e = Exact(pu, pv);
    }
    positive = e > 0 || (e == 0 && sign_ * (dv_ != 0 ? -dv_ : du_) > 0);
    return e;
  }

  /// Without its last digits, where those do not matter.
  double Near(double pu, double pv) const {
    return sign_ * (du_ * (pv - av_) - dv_ * (pu - au_));
  }

  /// Narrows the columns (low..high) that have E > 0 in a row. False if it is unsure of
  /// one of them: E changes its sign too near to it for doubles to tell.
  bool Narrow(const Grid& grid, double pv, double& low, double& high) const {
    if (dv_ == 0) {
      const double e = sign_ * du_ * (pv - av_);
      if (e < 0) high = -1;
      return e != 0;
    }
    const double column = (au_ - grid.u0_mm + du_ * ((pv - av_) / dv_)) / grid.step_mm;
    if (!(column > low - 1 && column < high + 1)) {
      // Far from the triangle's extent: all or nothing.
      if ((column > high) == (sign_ * dv_ < 0)) high = -1;
      return true;
    }
    if (sign_ * dv_ < 0) {
      low = std::max(low, std::ceil(column));
    } else {
      high = std::min(high, std::floor(column));
    }
    return std::abs(column - std::nearbyint(column)) > kUnsureColumns;
  }

  /// An upper bound of |first| + |second| over the triangle's extent.
  double Magnitude(double width, double height) const {
    return std::abs(du_) * height + std::abs(dv_) * width;
  }

 private:
  double au_, av_, du_, dv_, sign_;
};

struct Crossing {
  std::uint32_t column, row;
  double w_mm;
};

/// A triangle as the rays see it.
struct Footprint {
  std::array<EdgeFunction, 3> edges;        ///< E > 0 inside
  std::array<double, 3> opposite_w_mm;      ///< of the corner opposite to each edge
  double low_column = 0, high_column = -1;  ///< of its extent
  bool slender = false;                     ///< so that doubles do for no weights

  bool Holds(double pu, double pv) const {
    bool inside[3];
    for (std::size_t i = 0; i < 3; ++i) edges[i].At(pu, pv, inside[i]);
    return inside[0] && inside[1] && inside[2];
  }

  double HeightAt(double pu, double pv) const {
    double sum = 0, moment = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double weight = slender ? edges[i].Exact(pu, pv) : edges[i].Near(pu, pv);
      sum += weight;
      moment += weight * opposite_w_mm[i];
    }
    return moment / sum;
  }
};

class RayCaster {
 public:
  RayCaster(const Grid& grid, PointList vertices)
      : grid_(grid), vertices_(std::move(vertices)) {
    for (Vec3& v : vertices_) {
      v.x() = grid_.Rounded(v.x());
      v.y() = grid_.Rounded(v.y());
    }
  }

  void Cast(const mesh::Triangle& triangle);
  std::size_t crossing_count() const { return crossings_.size(); }
  /// Calls `visit` with the crossings of each ray that has any, from the lowest up.
  template <typename Visit>
  void ForEachRay(const Visit& visit);

 private:
  void CastRow(std::int64_t row, const Footprint& footprint);
  std::vector<Crossing> ByRow(std::vector<std::size_t>& row_begin);

  Grid grid_;
  PointList vertices_;
  std::vector<Crossing> crossings_;
};

void RayCaster::Cast(const mesh::Triangle& triangle) {
  const auto edge = [&](std::size_t i) {
    const std::uint32_t a = triangle[i], b = triangle[(i + 1) % 3];
    return a < b ? EdgeFunction(vertices_[a], vertices_[b], 1)
                 : EdgeFunction(vertices_[b], vertices_[a], -1);
  };
  const Vec3 &a = vertices_[triangle[0]], &b = vertices_[triangle[1]],
             &c = vertices_[triangle[2]];
  Footprint footprint = {{edge(0), edge(1), edge(2)}, {c.z(), a.z(), b.z()}};
  bool left_turn = false;
  const double doubled_area = footprint.edges[0].At(c.x(), c.y(), left_turn);
  if (doubled_area == 0) return;  // edge-on: its neighbours have the crossings
  double magnitude = 0;
  const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  for (EdgeFunction& e : footprint.edges) {
    if (doubled_area < 0) e.TurnOver();
    magnitude = std::max(magnitude, e.Magnitude(high.x() - low.x(), high.y() - low.y()));
  }
  footprint.slender = std::abs(doubled_area) < magnitude * (kErrorRatio / kWeightRatio);
  const auto index = [&](double mm, double origin_mm) {
    return (mm - origin_mm) / grid_.step_mm;
  };
  const auto first = [&](double at) { return std::max(0.0, std::floor(at)); };
  const auto last = [&](double at, std::int64_t count) {
    return std::min(static_cast<double>(count - 1), std::ceil(at));
  };
  footprint.low_column = first(index(low.x(), grid_.u0_mm));
  footprint.high_column = last(index(high.x(), grid_.u0_mm), grid_.count_u);
  const auto row = static_cast<std::int64_t>(first(index(low.y(), grid_.v0_mm)));
  const auto end =
      static_cast<std::int64_t>(last(index(high.y(), grid_.v0_mm), grid_.count_v));
  for (std::int64_t j = row; j <= end; ++j) CastRow(j, footprint);
}

void RayCaster::CastRow(std::int64_t row, const Footprint& footprint) {
  const double pv = grid_.V(row);
  double low = footprint.low_column, high = footprint.high_column;
  bool sure = true;
  for (const EdgeFunction& e : footprint.edges) sure &= e.Narrow(grid_, pv, low, high);
  if (!sure) {
    low = footprint.low_column;
    high = footprint.high_column;
  }
  for (double column = low; column <= high; ++column) {
    const double pu = grid_.u0_mm + column * grid_.step_mm;
    if (!sure && !footprint.Holds(pu, pv)) continue;
    crossings_.push_back({static_cast<std::uint32_t>(column),
                          static_cast<std::uint32_t>(row), footprint.HeightAt(pu, pv)});
  }
}

// By counting; within a row in the order of the triangles.
std::vector<Crossing> RayCaster::ByRow(std::vector<std::size_t>& row_begin) {
  row_begin.assign(static_cast<std::size_t>(grid_.count_v) + 1, 0);
  for (const Crossing& crossing : crossings_) ++row_begin[crossing.row + 1];
  std::partial_sum(row_begin.begin(), row_begin.end(), row_begin.begin());
  std::vector<std::size_t> next(row_begin.begin(), row_begin.end() - 1);
  std::vector<Crossing> sorted(crossings_.size());
  for (const Crossing& crossing : crossings_) sorted[next[crossing.row]++] = crossing;
  return sorted;
}

template <typename Visit>
void RayCaster::ForEachRay(const Visit& visit) {
  std::vector<std::size_t> row_begin;
  const std::vector<Crossing> by_row = ByRow(row_begin);
  std::vector<std::size_t> end_of_ray;
  std::vector<double> heights;
  for (std::size_t row = 0; row + 1 < row_begin.size(); ++row) {
    const std::size_t begin = row_begin[row], end = row_begin[row + 1];
    if (begin == end) continue;
    end_of_ray.assign(static_cast<std::size_t>(grid_.count_u) + 1, 0);
    for (std::size_t i = begin; i < end; ++i) ++end_of_ray[by_row[i].column + 1];
    std::partial_sum(end_of_ray.begin(), end_of_ray.end(), end_of_ray.begin());
    heights.resize(end - begin);
    // What was the beginning of a ray is its end when all are in.
    for (std::size_t i = begin; i < end; ++i) {
      heights[end_of_ray[by_row[i].column]++] = by_row[i].w_mm;
    }
    std::size_t from = 0;
    for (std::size_t column = 0; from < heights.size(); ++column) {
      const std::size_t to = end_of_ray[column];
      if (from == to) continue;
      const std::span<double> ray(heights.data() + from, to - from);
      std::sort(ray.begin(), ray.end());
      visit(grid_.U(static_cast<std::int64_t>(column)),
            grid_.V(static_cast<std::int64_t>(row)), ray);
      from = to;
    }
  }
}

}  // namespace

Result<MethodStatistics> CrossRays(const mesh::TriangleMesh& mesh,
                                   const RayOptions& options, std::uint32_t source,
                                   const ProgressSink& progress, PointCloud& cloud) {
  Require(options.distance_mm > 0, "distance_mm must be positive, is {}",
          options.distance_mm);
  const Mat3 frame = FrameOf(options.direction);
  Box3 bounds;
  PointList vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) {
    vertices.emplace_back(frame.transpose() * v);
    bounds.Extend(vertices.back());
  }
  MethodStatistics statistics;
  if (bounds.empty()) return statistics;
  const Result<Grid> grid = GridOver(bounds, options.distance_mm);
  if (!grid) return tl::unexpected(grid.error());
  RayCaster caster(*grid, std::move(vertices));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % kTrianglesPerReport == 0 && progress && !progress(t, mesh.triangles.size())) {
      return Fail(ErrorCode::kCancelled, "casting rays was cancelled");
    }
    caster.Cast(mesh.triangles[t]);
    const Status few =
        CheckCandidateCount(static_cast<double>(cloud.size() + caster.crossing_count()));
    if (!few) return tl::unexpected(few.error());
  }
  caster.ForEachRay([&](double u_mm, double v_mm, std::span<const double> heights_mm) {
    ++statistics.ray_count;
    statistics.odd_ray_count += heights_mm.size() % 2;
    statistics.point_count += heights_mm.size();
    for (const double w_mm : heights_mm) {
      cloud.Add(frame * Vec3(u_mm, v_mm, w_mm), source);
    }
  });
  return statistics;
}

}  // namespace intaglio::discretize
