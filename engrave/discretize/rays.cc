#include "engrave/discretize/rays.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

// In the frame (u, v, w) of the rays a triangle is met by ray p if p is on the same side
// of its three edges. The side of edge a -> b is the sign of
//   E = (b - a) x (p - a),
// always computed from the lower-numbered vertex to the higher and turned over where the
// triangle passes the edge the other way, so both triangles of an edge agree. Where E is
// too small for doubles it is computed again with 113 bits, in which differences of
// coordinates of like size and their products are exact. E = 0: the ray is moved by (e,
// e^2) with an infinitesimal e, and the sign is that of -(b_v - a_v), or of (b_u - a_u)
// if that is zero.

namespace intaglio::discretize {
namespace {

constexpr std::uint64_t kMaxRays = std::uint64_t{1} << 31;
constexpr std::uint64_t kTrianglesPerReport = 8192;
// Error of E in doubles is below 4 roundings of each product.
constexpr double kErrorRatio = 16 * 2.3e-16;

int SideOf(const Vec3& a, const Vec3& b, double pu, double pv) {
  const double first = (b.x() - a.x()) * (pv - a.y());
  const double second = (b.y() - a.y()) * (pu - a.x());
  const double e = first - second;
  if (std::abs(e) > kErrorRatio * (std::abs(first) + std::abs(second)))
    return e > 0 ? 1 : -1;
  using Wide = __float128;
  const Wide exact = (Wide(b.x()) - a.x()) * (Wide(pv) - a.y()) -
                     (Wide(b.y()) - a.y()) * (Wide(pu) - a.x());
  if (exact != 0) return exact > 0 ? 1 : -1;
  if (a.y() != b.y()) return b.y() < a.y() ? 1 : -1;
  if (a.x() != b.x()) return b.x() > a.x() ? 1 : -1;
  return 0;  // the edge is a point as the rays see it: no ray passes beside it
}

struct Grid {
  double u0 = 0, v0 = 0, step = 1;  // of ray (0, 0)
  std::int64_t count_u = 0, count_v = 0;

  double U(std::int64_t i) const { return u0 + static_cast<double>(i) * step; }
  double V(std::int64_t j) const { return v0 + static_cast<double>(j) * step; }
};

Grid GridOver(const Box3& bounds, double distance_mm) {
  Grid grid;
  grid.step = distance_mm * kRoundingAllowance;
  const Vec3 size = bounds.size_mm(), center = bounds.center_mm();
  grid.count_u = static_cast<std::int64_t>(std::floor(size.x() / grid.step)) + 1;
  grid.count_v = static_cast<std::int64_t>(std::floor(size.y() / grid.step)) + 1;
  grid.u0 = center.x() - 0.5 * static_cast<double>(grid.count_u - 1) * grid.step;
  grid.v0 = center.y() - 0.5 * static_cast<double>(grid.count_v - 1) * grid.step;
  return grid;
}

struct Crossing {
  std::uint64_t ray;
  double w;
};

class RayCaster {
 public:
  RayCaster(const mesh::TriangleMesh& mesh, const RayOptions& options)
      : mesh_(mesh), frame_(FrameOf(options.direction)) {
    Box3 bounds;
    vertices_.reserve(mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) {
      vertices_.push_back(frame_.transpose() * v);
      bounds.Extend(vertices_.back());
    }
    if (!bounds.empty()) grid_ = GridOver(bounds, options.distance_mm);
  }

  const Grid& grid() const { return grid_; }
  void Cast(const mesh::Triangle& triangle);
  /// Ray by ray, each from its lowest crossing up.
  std::vector<Crossing>& Sorted();
  Vec3 PointOf(const Crossing& crossing) const {
    const auto i = static_cast<std::int64_t>(crossing.ray) % grid_.count_u;
    const auto j = static_cast<std::int64_t>(crossing.ray) / grid_.count_u;
    return frame_ * Vec3(grid_.U(i), grid_.V(j), crossing.w);
  }

 private:
  bool Meets(const mesh::Triangle& triangle, double pu, double pv) const;
  const mesh::TriangleMesh& mesh_;
  Mat3 frame_;
  PointList vertices_;
  Grid grid_;
  std::vector<Crossing> crossings_;
};

bool RayCaster::Meets(const mesh::Triangle& triangle, double pu, double pv) const {
  int common = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t a = triangle[i], b = triangle[(i + 1) % 3];
    const int side = a < b ? SideOf(vertices_[a], vertices_[b], pu, pv)
                           : -SideOf(vertices_[b], vertices_[a], pu, pv);
    if (side == 0 || (i > 0 && side != common)) return false;
    common = side;
  }
  return true;
}

void RayCaster::Cast(const mesh::Triangle& triangle) {
  const Vec3 &a = vertices_[triangle[0]], &b = vertices_[triangle[1]],
             &c = vertices_[triangle[2]];
  const auto first = [](double low, double origin, double step) {
    return static_cast<std::int64_t>(std::floor((low - origin) / step));
  };
  const auto last = [](double high, double origin, double step) {
    return static_cast<std::int64_t>(std::ceil((high - origin) / step));
  };
  const auto [low_u, high_u] = std::minmax({a.x(), b.x(), c.x()});
  const auto [low_v, high_v] = std::minmax({a.y(), b.y(), c.y()});
  const std::int64_t i0 = std::max<std::int64_t>(0, first(low_u, grid_.u0, grid_.step));
  const std::int64_t i1 = std::min(grid_.count_u - 1, last(high_u, grid_.u0, grid_.step));
  const std::int64_t j0 = std::max<std::int64_t>(0, first(low_v, grid_.v0, grid_.step));
  const std::int64_t j1 = std::min(grid_.count_v - 1, last(high_v, grid_.v0, grid_.step));
  const Vec3 normal = (b - a).cross(c - a);
  const auto [low_w, high_w] = std::minmax({a.z(), b.z(), c.z()});
  for (std::int64_t j = j0; j <= j1; ++j) {
    for (std::int64_t i = i0; i <= i1; ++i) {
      const double pu = grid_.U(i), pv = grid_.V(j);
      if (!Meets(triangle, pu, pv)) continue;
      // On the plane of the triangle; seen edge-on it is any height of it.
      const double w =
          a.z() - (normal.x() * (pu - a.x()) + normal.y() * (pv - a.y())) / normal.z();
      crossings_.push_back({static_cast<std::uint64_t>(j * grid_.count_u + i),
                            std::isfinite(w) ? std::clamp(w, low_w, high_w) : low_w});
    }
  }
}

std::vector<Crossing>& RayCaster::Sorted() {
  std::sort(crossings_.begin(), crossings_.end(),
            [](const Crossing& x, const Crossing& y) {
              return x.ray != y.ray ? x.ray < y.ray : x.w < y.w;
            });
  return crossings_;
}

}  // namespace

Result<MethodStatistics> CrossRays(const mesh::TriangleMesh& mesh,
                                   const RayOptions& options, std::uint32_t source,
                                   const ProgressSink& progress, PointCloud& cloud) {
  Require(options.distance_mm > 0, "distance_mm must be positive, is {}",
          options.distance_mm);
  RayCaster caster(mesh, options);
  const auto rays = static_cast<double>(caster.grid().count_u) *
                    static_cast<double>(caster.grid().count_v);
  if (rays > static_cast<double>(kMaxRays)) {
    return Fail(
        ErrorCode::kTooLarge,
        fmt::format("a grid of {:.3g} rays is too fine for the model; take a larger "
                    "distance than {} mm",
                    rays, options.distance_mm),
        fmt::format("{}", options.distance_mm));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % kTrianglesPerReport == 0 && progress && !progress(t, mesh.triangles.size())) {
      return Fail(ErrorCode::kCancelled, "casting rays was cancelled");
    }
    caster.Cast(mesh.triangles[t]);
  }
  MethodStatistics statistics;
  std::uint64_t on_ray = 0, ray = 0;
  const auto finish_ray = [&] {
    if (on_ray == 0) return;
    ++statistics.ray_count;
    statistics.odd_ray_count += on_ray % 2;
    on_ray = 0;
  };
  for (const Crossing& crossing : caster.Sorted()) {
    if (crossing.ray != ray) finish_ray();
    ray = crossing.ray;
    ++on_ray;
    ++statistics.point_count;
    cloud.Add(caster.PointOf(crossing), source);
  }
  finish_ray();
  return statistics;
}

}  // namespace intaglio::discretize
