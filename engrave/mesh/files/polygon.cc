#include "engrave/mesh/files/polygon.h"

#include <Eigen/Geometry>
#include <cmath>

namespace intaglio::mesh {
namespace {

using Corners = std::vector<std::array<std::size_t, 3>>;

double Cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
double Turn(const Vec2& a, const Vec2& b, const Vec2& c) { return Cross(b - a, c - a); }

/// Twice the area, as a vector.
Vec3 NewellNormal(std::span<const Vec3> corners) {
  Vec3 normal = Vec3::Zero();
  const Vec3 origin = corners.front();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    normal += (corners[i] - origin).cross(corners[(i + 1) % corners.size()] - origin);
  }
  return normal;
}

std::vector<Vec2> InPlane(std::span<const Vec3> corners, const Vec3& normal) {
  const Vec3 z = normal.normalized();
  const Vec3 x = z.unitOrthogonal(), y = z.cross(x);
  std::vector<Vec2> flat;
  for (const Vec3& corner : corners) {
    const Vec3 p = corner - corners.front();
    flat.emplace_back(p.dot(x), p.dot(y));
  }
  return flat;
}

Corners Fan(std::size_t count) {
  Corners triangles;
  for (std::size_t i = 2; i < count; ++i) triangles.push_back({0, i - 1, i});
  return triangles;
}

bool IsConvex(const std::vector<Vec2>& flat) {
  const std::size_t n = flat.size();
  double turn = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = flat[(i + 1) % n] - flat[i], b = flat[(i + 2) % n] - flat[(i + 1) % n];
    if (Cross(a, b) < 0) return false;
    turn += std::atan2(Cross(a, b), a.dot(b));
  }
  return turn < 7;  // once around
}

/// The polygon that is left while ears are cut.
class Ears {
 public:
  explicit Ears(const std::vector<Vec2>& flat) : flat_(flat) {
    for (std::size_t i = 0; i < flat.size(); ++i) left_.push_back(i);
  }

  Corners Cut() {
    Corners triangles;
    std::size_t at = 0, missed = 0;
    while (left_.size() > 3 && missed <= left_.size()) {
      const std::size_t n = left_.size();
      at %= n;
      const std::size_t a = left_[(at + n - 1) % n], b = left_[at],
                        c = left_[(at + 1) % n];
      if (!IsEar(a, b, c)) {
        ++at;
        ++missed;
        continue;
      }
      triangles.push_back({a, b, c});
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(at));
      missed = 0;
    }
    if (left_.size() == 3) triangles.push_back({left_[0], left_[1], left_[2]});
    return triangles;
  }

 private:
  /// Corners in line are ears without an area, when their neighbour is not inside.
  bool IsEar(std::size_t a, std::size_t b, std::size_t c) const {
    const Vec2 &p = flat_[a], &q = flat_[b], &r = flat_[c];
    const double turn = Turn(p, q, r);
    if (turn < 0) return false;
    if (turn == 0) return (q - p).dot(r - q) >= 0;
    for (const std::size_t i : left_) {
      if (i == a || i == b || i == c) continue;
      const Vec2& s = flat_[i];
      if (s == p || s == q || s == r) continue;
      if (Turn(p, q, s) >= 0 && Turn(q, r, s) >= 0 && Turn(r, p, s) >= 0) return false;
    }
    return true;
  }

  const std::vector<Vec2>& flat_;
  std::vector<std::size_t> left_;
};

double AreaOf(const Corners& triangles, const std::vector<Vec2>& flat) {
  double area = 0;
  for (const auto& [a, b, c] : triangles)
    area += std::abs(Turn(flat[a], flat[b], flat[c]));
  return area;
}

}  // namespace

std::optional<Corners> TriangulatePolygon(std::span<const Vec3> corners) {
  if (corners.size() <= 3) return Fan(corners.size());
  const Vec3 normal = NewellNormal(corners);
  if (!(normal.norm() > 0)) return Fan(corners.size());
  const std::vector<Vec2> flat = InPlane(corners, normal);
  if (IsConvex(flat)) return Fan(corners.size());
  if (corners.size() > kMaxPolygonCorners) return std::nullopt;
  Corners triangles = Ears(flat).Cut();
  const bool whole =
      std::abs(AreaOf(triangles, flat) - normal.norm()) <= 1e-6 * normal.norm();
  if (!whole || triangles.size() != corners.size() - 2) return std::nullopt;
  return triangles;
}

}  // namespace intaglio::mesh
