#include "engrave/proof/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
// The number of triangles is halved at every level, so even 2^32 of them need fewer
// levels.
constexpr std::size_t kMaxLevels = 64;

/// a x b without Eigen's geometry module, which would be compiled for this alone.
Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
          a.x() * b.y() - a.y() * b.x()};
}

Vec3 NearestOnSide(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double square = along.squaredNorm();
  const double t = square > 0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return a + t * along;
}

double SquareToBox(const Box3& box, const Vec3& p) {
  return (box.min_mm - p).cwiseMax(p - box.max_mm).cwiseMax(0.0).squaredNorm();
}

/// Twice the middle, which orders as the middle does.
Vec3 MiddleOf(const Corners& t) {
  return t[0].cwiseMin(t[1]).cwiseMin(t[2]) + t[0].cwiseMax(t[1]).cwiseMax(t[2]);
}

}  // namespace

double AreaOf(const Corners& t) { return 0.5 * Cross(t[1] - t[0], t[2] - t[0]).norm(); }

std::array<Corners, 2> HalvesOf(const Corners& t) {
  std::size_t longest = 0;
  double square = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const double side = (t[(i + 1) % 3] - t[i]).squaredNorm();
    if (side > square) {
      square = side;
      longest = i;
    }
  }
  const Vec3 &a = t[longest], &b = t[(longest + 1) % 3], &c = t[(longest + 2) % 3];
  const Vec3 middle = 0.5 * (a + b);
  return {Corners{a, middle, c}, Corners{middle, b, c}};
}

Vec3 NearestPlaceOf(const Corners& t, const Vec3& p) {
  const Vec3 normal = Cross(t[1] - t[0], t[2] - t[0]);
  const double square = normal.squaredNorm();
  bool inside = square > 0;
  for (std::size_t i = 0; i < 3 && inside; ++i) {
    inside = Cross(t[(i + 1) % 3] - t[i], p - t[i]).dot(normal) >= 0;
  }
  if (inside) return p - (p - t[0]).dot(normal) / square * normal;
  Vec3 nearest = t[0];
  double smallest = (p - t[0]).squaredNorm();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 place = NearestOnSide(t[i], t[(i + 1) % 3], p);
    const double distance = (p - place).squaredNorm();
    if (distance < smallest) {
      smallest = distance;
      nearest = place;
    }
  }
  return nearest;
}

Surface::Surface(const std::vector<mesh::TriangleMesh>& models, double max_area_mm2,
                 std::size_t max_pieces) {
  Require(max_area_mm2 > 0, "max_area_mm2 is {}", max_area_mm2);
  std::vector<Corners> open;
  for (const mesh::TriangleMesh& model : models) {
    for (const mesh::Triangle& t : model.triangles) {
      open.push_back({model.vertices[t[0]], model.vertices[t[1]], model.vertices[t[2]]});
    }
  }
  Require(!open.empty(), "a surface of no triangles");
  const std::size_t limit = open.size() + max_pieces;
  triangles_.reserve(open.size());
  while (!open.empty()) {
    const Corners triangle = open.back();
    open.pop_back();
    if (AreaOf(triangle) > max_area_mm2 && open.size() + triangles_.size() + 2 <= limit) {
      const auto halves = HalvesOf(triangle);
      open.insert(open.end(), halves.begin(), halves.end());
    } else {
      triangles_.push_back(triangle);
    }
  }
  Require(triangles_.size() < std::numeric_limits<std::uint32_t>::max(),
          "a surface of {} triangles is too large", triangles_.size());
  nodes_.reserve(triangles_.size());
  Build(triangles_, 0, static_cast<std::uint32_t>(triangles_.size()));
}

void Surface::Build(std::vector<Corners>& triangles, std::uint32_t begin,
                    std::uint32_t end) {
  const std::size_t own = nodes_.size();
  Node node;
  node.begin = begin;
  node.end = end;
  Box3 middles;
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const Vec3& corner : triangles[i]) node.box.Extend(corner);
    middles.Extend(MiddleOf(triangles[i]));
  }
  nodes_.push_back(node);
  if (end - begin <= kLeafTriangles) return;
  Eigen::Index axis = 0;
  middles.size_mm().maxCoeff(&axis);
  const std::uint32_t half = begin + (end - begin) / 2;
  const auto first = triangles.begin();
  std::nth_element(first + begin, first + half, first + end,
                   [axis](const Corners& a, const Corners& b) {
                     return MiddleOf(a)[axis] < MiddleOf(b)[axis];
                   });
  Build(triangles, begin, half);
  nodes_[own].right = static_cast<std::uint32_t>(nodes_.size());
  Build(triangles, half, end);
}

Surface::Place Surface::NearestTo(const Vec3& p_mm, std::uint32_t near_triangle) const {
  Place best;
  const auto target = [&](std::uint32_t triangle) {
    const Vec3 at_mm = NearestPlaceOf(triangles_[triangle], p_mm);
    const double square = (p_mm - at_mm).squaredNorm();
    if (square < best.square_mm2) best = {triangle, at_mm, square};
  };
  best.square_mm2 = std::numeric_limits<double>::infinity();
  target(near_triangle);
  struct Open {
    std::uint32_t node;
    double square;
  };
  std::array<Open, kMaxLevels> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, SquareToBox(nodes_[0].box, p_mm)};
  while (depth > 0) {
    const Open open = stack[--depth];
    if (open.square >= best.square_mm2) continue;
    const Node& node = nodes_[open.node];
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) target(i);
      continue;
    }
    const Open left{open.node + 1, SquareToBox(nodes_[open.node + 1].box, p_mm)};
    const Open right{node.right, SquareToBox(nodes_[node.right].box, p_mm)};
    const bool left_first = left.square <= right.square;
    stack[depth++] = left_first ? right : left;
    stack[depth++] = left_first ? left : right;
  }
  return best;
}

}  // namespace intaglio::proof
