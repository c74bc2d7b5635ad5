#include "engrave/discretize/mesh/shells.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/mesh/vertex_normals.h"

namespace intaglio::discretize {
namespace {

// So stiff that a vertex on a plane moves along the normal alone, and so soft that it
// moves by the depth to a thousandth.
constexpr double kStiffness = 1e-3;
constexpr double kMaxMove = 4;  // depths, at sharp needles
// Samples of the surface are this apart, in depths, and none is nearer than this to a
// place that is deep: the nearest place of the surface is, if it lies between samples,
// 0.65 steps from one (surface_grid.cc), and sqrt(0.87^2 + (0.65 / 4)^2) = 0.885.
constexpr double kStepRatio = 0.25, kReachRatio = 0.89;

}  // namespace

// Vertex x moves by d that minimizes sum w (n d + depth)^2 over its triangles' normals n,
// weighted by their angles, plus a little for moving at all.
mesh::TriangleMesh Inward(const mesh::TriangleMesh& mesh, double depth_mm) {
  struct Sums {
    Mat3 square = Mat3::Zero();
    Vec3 normal = Vec3::Zero();
    double weight = 0;
  };
  std::vector<Sums> sums(mesh.vertices.size());
  for (const mesh::Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
               &c = mesh.vertices[t[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized(),
               angles = mesh::AnglesOf(a, b, c);
    if (!normal.allFinite()) continue;
    for (int i = 0; i < 3; ++i) {
      sums[t[i]].square += angles[i] * normal * normal.transpose();
      sums[t[i]].normal += angles[i] * normal;
      sums[t[i]].weight += angles[i];
    }
  }
  mesh::TriangleMesh moved = mesh;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (!(sums[i].weight > 0)) continue;
    const Mat3 stiff = kStiffness * sums[i].weight * Mat3::Identity();
    // With the stiffness on both sides a plane's vertex moves by the depth exactly.
    const Vec3 pull = sums[i].normal * (1 + kStiffness);
    Vec3 move = (sums[i].square + stiff).ldlt().solve(pull) * -depth_mm;
    if (move.norm() > kMaxMove * depth_mm) move *= kMaxMove * depth_mm / move.norm();
    moved.vertices[i] += move;
  }
  return moved;
}

Result<DepthCheck> DepthCheck::Make(const mesh::TriangleMesh& mesh, double depth_mm) {
  Require(depth_mm > 0, "depth_mm must be positive, is {}", depth_mm);
  PointList samples;
  const SurfaceGrid grid(mesh, {kStepRatio * depth_mm});
  INTAGLIO_TRY(
      grid.ForEach({}, {}, [&](const SurfacePoint& s) { samples.push_back(s.p_mm); }));
  return DepthCheck(grid.bounds(), depth_mm, std::move(samples));
}

DepthCheck::DepthCheck(const Box3& bounds, double depth_mm, PointList samples)
    : origin_(bounds.min_mm.head<2>()), reach_mm_(kReachRatio * depth_mm) {
  const Vec3 size = bounds.size_mm();
  // No more columns than samples justify.
  const double largest = 64 + static_cast<double>(samples.size());
  double side_mm = reach_mm_;
  while ((size.x() / side_mm + 1) * (size.y() / side_mm + 1) > largest) side_mm *= 1.25;
  per_side_ = 1 / side_mm;
  width_ = static_cast<std::size_t>(size.x() * per_side_) + 1;
  depth_ = static_cast<std::size_t>(size.y() * per_side_) + 1;
  begin_.assign(width_ * depth_ + 1, 0);
  for (const Vec3& s : samples) ++begin_[ColumnOf(s.x(), s.y()) + 1];
  for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  samples_.resize(samples.size());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (const Vec3& s : samples) samples_[next[ColumnOf(s.x(), s.y())]++] = s;
  for (std::size_t c = 0; c + 1 < begin_.size(); ++c) {
    std::sort(samples_.begin() + begin_[c], samples_.begin() + begin_[c + 1],
              [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  }
}

std::size_t DepthCheck::ColumnOf(double x_mm, double y_mm) const {
  const auto at = [this](double offset_mm, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp(offset_mm * per_side_, 0.0, static_cast<double>(count - 1)));
  };
  return at(y_mm - origin_.y(), depth_) * width_ + at(x_mm - origin_.x(), width_);
}

bool DepthCheck::IsDeep(const Vec3& p) const {
  const double square = reach_mm_ * reach_mm_;
  const std::size_t first = ColumnOf(p.x() - reach_mm_, p.y() - reach_mm_);
  const std::size_t last = ColumnOf(p.x() + reach_mm_, p.y() + reach_mm_);
  for (std::size_t row = first / width_; row <= last / width_; ++row) {
    for (std::size_t i = first % width_; i <= last % width_; ++i) {
      const std::size_t column = row * width_ + i;
      const auto end = samples_.begin() + begin_[column + 1];
      auto at =
          std::partition_point(samples_.begin() + begin_[column], end,
                               [&](const Vec3& s) { return s.z() <= p.z() - reach_mm_; });
      for (; at != end && at->z() < p.z() + reach_mm_; ++at) {
        if ((*at - p).squaredNorm() < square) return false;
      }
    }
  }
  return true;
}

}  // namespace intaglio::discretize
