#include "engrave/mesh/base_face.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace intaglio::mesh {
namespace {

/// What counts as flat.
struct Flatness {
  double depth_share;  // of the model's extent
  double cosine;       // of the angle to the normal of the face
  double flat_share, not_flat_share;
};

constexpr std::array<Flatness, 2> kMadeAndScanned = {
    {{0.002, 0.99939, 0.3, 0.02}, {0.02, 0.951, 0.1, 0.05}}};

/// Area of the triangles on the low and on the high face of the box along one axis, as a
/// share of that face.
struct FaceShares {
  double low = 0, high = 0;
};

FaceShares SharesAlong(int axis, const TriangleMesh& mesh, const Box3& box,
                       const Flatness& flatness) {
  const Vec3 size_mm = box.size_mm();
  const double depth_mm = flatness.depth_share * size_mm.maxCoeff();
  const double face_mm2 = size_mm[(axis + 1) % 3] * size_mm[(axis + 2) % 3];
  FaceShares shares;
  if (!(face_mm2 > 0) || size_mm[axis] <= 2 * depth_mm) return shares;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
               &c = mesh.vertices[t[2]];
    const double low_mm = std::min({a[axis], b[axis], c[axis]});
    const double high_mm = std::max({a[axis], b[axis], c[axis]});
    const bool at_low = high_mm <= box.min_mm[axis] + depth_mm;
    const bool at_high = low_mm >= box.max_mm[axis] - depth_mm;
    if (!at_low && !at_high) continue;
    const Vec3 normal = (b - a).cross(c - a);
    if (std::abs(normal[axis]) < flatness.cosine * normal.norm()) continue;
    (at_low ? shares.low : shares.high) += 0.5 * std::abs(normal[axis]) / face_mm2;
  }
  return shares;
}

}  // namespace

std::optional<UpAxis> UpOfBaseFace(const TriangleMesh& placed) {
  const Box3 box = placed.Bounds();
  if (box.empty()) return std::nullopt;
  for (const Flatness& flatness : kMadeAndScanned) {
    const FaceShares z = SharesAlong(2, placed, box, flatness);
    if (z.low >= flatness.not_flat_share) return std::nullopt;
    const FaceShares y = SharesAlong(1, placed, box, flatness);
    const bool at_top = z.high >= flatness.flat_share;
    const bool in_front =
        y.low >= flatness.flat_share && y.high < flatness.not_flat_share;
    if (at_top && in_front) return std::nullopt;
    if (at_top) return UpAxis::kMinusZ;
    if (in_front) return UpAxis::kY;
  }
  return std::nullopt;
}

bool RestsOnBase(const TriangleMesh& placed) {
  const Box3 box = placed.Bounds();
  if (box.empty()) return false;
  for (const Flatness& flatness : kMadeAndScanned) {
    const FaceShares z = SharesAlong(2, placed, box, flatness);
    if (z.low < flatness.flat_share) continue;
    const auto not_flat = [&](double share) { return share < flatness.not_flat_share; };
    if (!not_flat(z.high)) return false;
    for (const int axis : {0, 1}) {
      const FaceShares sides = SharesAlong(axis, placed, box, flatness);
      if (!not_flat(sides.low) || !not_flat(sides.high)) return false;
    }
    return true;
  }
  return false;
}

}  // namespace intaglio::mesh
