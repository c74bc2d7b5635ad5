#include "engrave/mesh/mesh_diagnosis.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "engrave/mesh/half_edges.h"

// Orientation. Two triangles that share an edge and pass it in opposite ways face the
// same side (relation 0); passing it the same way they face opposite sides (relation 1).
// A union-find whose links carry the relation to the parent gives every triangle's
// side relative to its part's root; the smaller side of a part is the flipped one. A
// link between triangles already joined that contradicts their sides closes a
// Moebius strip.
//
// Volume, by the divergence theorem: the sum over triangles of a . (b x c) / 6, taken
// from the centre of the bounds so that a far-off model does not cancel digits away.

namespace intaglio::mesh {
namespace {

// The sign of the volume of an open or damaged surface is certain when it encloses this
// share of its bounding box, and few of its edges are open.
constexpr double kVolumeShare = 0.02, kOpenEdgeShare = 0.05;
constexpr double kDegenerateRatio = 1e-12;

/// Parts of the mesh, and each triangle's side relative to the root of its part.
class SideForest {
 public:
  explicit SideForest(std::size_t count)
      : parent_(count), size_(count, 1), opposite_(count, 0) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  struct Root {
    std::uint32_t index;
    bool opposite;
  };

  Root Find(std::uint32_t node) {
    Root root{node, false};
    while (parent_[root.index] != root.index) {
      root.opposite ^= opposite_[root.index] != 0;
      root.index = parent_[root.index];
    }
    bool opposite = root.opposite;
    while (parent_[node] != root.index && node != root.index) {
      const std::uint32_t next = parent_[node];
      const bool next_opposite = opposite ^ (opposite_[node] != 0);
      parent_[node] = root.index;
      opposite_[node] = opposite;
      node = next;
      opposite = next_opposite;
    }
    return root;
  }

  /// Joins two triangles. False when their sides contradict `opposite`.
  bool Join(std::uint32_t a, std::uint32_t b, bool opposite) {
    Root root_a = Find(a);
    Root root_b = Find(b);
    const bool relation = root_a.opposite ^ root_b.opposite ^ opposite;
    if (root_a.index == root_b.index) return !relation;
    if (size_[root_a.index] < size_[root_b.index]) std::swap(root_a, root_b);
    parent_[root_b.index] = root_a.index;
    opposite_[root_b.index] = relation;
    size_[root_a.index] += size_[root_b.index];
    return true;
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint32_t> size_;
  std::vector<std::uint8_t> opposite_;  // to the parent
};

void CountShapes(const TriangleMesh& mesh, MeshDiagnosis& diagnosis) {
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t corner : t) {
      Require(corner < mesh.vertices.size(), "triangle corner {} of {} vertices", corner,
              mesh.vertices.size());
      used[corner] = true;
    }
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!used[v]) continue;
    ++diagnosis.vertex_count;
    diagnosis.bounds_mm.Extend(mesh.vertices[v]);
  }
  const Vec3 center_mm =
      diagnosis.bounds_mm.empty() ? Vec3(Vec3::Zero()) : diagnosis.bounds_mm.center_mm();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - center_mm;
    const Vec3 b = mesh.vertices[t[1]] - center_mm;
    const Vec3 c = mesh.vertices[t[2]] - center_mm;
    const double twice_area_mm2 = (b - a).cross(c - a).norm();
    const double longest_sq_mm2 =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if (HasRepeatedCorner(t) || twice_area_mm2 <= kDegenerateRatio * longest_sq_mm2) {
      ++diagnosis.degenerate_triangle_count;
    }
    diagnosis.area_mm2 += twice_area_mm2 / 2;
    diagnosis.signed_volume_mm3 += a.dot(b.cross(c)) / 6;
  }
}

std::uint64_t RepeatedIn(std::vector<Triangle>& sorted_triangles) {
  std::sort(sorted_triangles.begin(), sorted_triangles.end());
  const auto last = std::unique(sorted_triangles.begin(), sorted_triangles.end());
  return static_cast<std::uint64_t>(std::distance(last, sorted_triangles.end()));
}

/// The triangles on the edges, as far as their number matters.
class EdgeCount {
 public:
  EdgeCount(const TriangleMesh& mesh, MeshDiagnosis& diagnosis)
      : mesh_(mesh), diagnosis_(diagnosis), sides_(mesh.triangles.size()) {}

  void Add(std::uint32_t low, std::span<const HalfEdge> edge) {
    ++diagnosis_.edge_count;
    if (edge.size() == 1) {
      ++diagnosis_.open_edge_count;
      return;
    }
    if (edge.size() == 2) {
      const bool flipped = edge[0].upward() == edge[1].upward();
      if (flipped) ++diagnosis_.flipped_edge_count;
      if (!sides_.Join(edge[0].triangle(), edge[1].triangle(), flipped)) {
        diagnosis_.orientable = false;
      }
    } else {
      ++diagnosis_.non_manifold_edge_count;
      for (const HalfEdge half : edge.subspan(1)) {
        joined_by_many_.emplace_back(edge[0].triangle(), half.triangle());
      }
    }
    CountDuplicates(low, edge);
  }

  /// When all edges are in.
  void CountParts() {
    SideForest parts(mesh_.triangles.size());
    for (const auto& [a, b] : joined_by_many_) {
      parts.Join(sides_.Find(a).index, sides_.Find(b).index, false);
    }
    // Per root of the sides: triangles on the root's side and on the other.
    std::vector<std::array<std::uint32_t, 2>> side_counts(mesh_.triangles.size(), {0, 0});
    std::uint64_t edged_triangle_count = 0;
    std::vector<Triangle> edgeless;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (HasRepeatedCorner(mesh_.triangles[t])) {
        edgeless.push_back(mesh_.triangles[t]);
        std::sort(edgeless.back().begin(), edgeless.back().end());
        continue;
      }
      ++edged_triangle_count;
      const SideForest::Root root = sides_.Find(t);
      if (root.index == t && parts.Find(t).index == t) ++diagnosis_.component_count;
      ++side_counts[root.index][root.opposite ? 1 : 0];
    }
    diagnosis_.duplicate_triangle_count += RepeatedIn(edgeless);
    for (const auto& counts : side_counts) {
      diagnosis_.flipped_triangle_count += std::min(counts[0], counts[1]);
    }
    diagnosis_.euler_characteristic = static_cast<std::int64_t>(diagnosis_.vertex_count) -
                                      static_cast<std::int64_t>(diagnosis_.edge_count) +
                                      static_cast<std::int64_t>(edged_triangle_count);
  }

 private:
  /// Triangles of the same corners share three edges; they are counted on the one between
  /// their two lowest vertices.
  void CountDuplicates(std::uint32_t low, std::span<const HalfEdge> edge) {
    thirds_.clear();
    for (const HalfEdge half : edge) {
      const Triangle& t = mesh_.triangles[half.triangle()];
      const std::uint32_t third = t[0] ^ t[1] ^ t[2] ^ low ^ half.high();
      if (third > half.high()) thirds_.push_back({low, half.high(), third});
    }
    if (thirds_.size() > 1) diagnosis_.duplicate_triangle_count += RepeatedIn(thirds_);
  }

  const TriangleMesh& mesh_;
  MeshDiagnosis& diagnosis_;
  SideForest sides_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joined_by_many_;
  std::vector<Triangle> thirds_;
};

}  // namespace

MeshDiagnosis Diagnose(const TriangleMesh& mesh) {
  MeshDiagnosis diagnosis;
  diagnosis.triangle_count = mesh.triangles.size();
  CountShapes(mesh, diagnosis);
  EdgeCount edges(mesh, diagnosis);
  HalfEdges(mesh).ForEachEdge(
      [&](std::uint32_t low, std::span<const HalfEdge> edge) { edges.Add(low, edge); });
  edges.CountParts();
  return diagnosis;
}

bool MeshDiagnosis::inside_out() const {
  if (!orientable || !(signed_volume_mm3 < 0)) return false;
  if (closed() && flipped_edge_count == 0) return true;
  const auto few = [](std::uint64_t count, std::uint64_t of) {
    return static_cast<double>(count) <= kOpenEdgeShare * static_cast<double>(of);
  };
  return few(open_edge_count, edge_count) &&
         few(flipped_triangle_count, triangle_count) &&
         -signed_volume_mm3 > kVolumeShare * bounds_mm.size_mm().prod();
}

Warnings WarningsOf(const MeshDiagnosis& d, std::string_view model_name) {
  Warnings warnings;
  const auto warn_if = [&](std::uint64_t count, WarningCode code,
                           const std::string& sentence) {
    if (count > 0)
      warnings.push_back(MakeWarning(code, fmt::format("{}: {}", model_name, sentence)));
  };
  const auto triangles = [](std::uint64_t count, const char* of_one, const char* of_more,
                            const char* what) {
    return fmt::format("{} {} {}", Counted(count, "triangle"),
                       VerbFor(count, of_one, of_more), what);
  };
  warn_if(
      d.open_edge_count, WarningCode::kOpenSurface,
      fmt::format("the surface is open along {}; points are made on it, but contours "
                  "there do not close: fill the holes in a mesh editor if they are not "
                  "intended",
                  Counted(d.open_edge_count, "edge")));
  warn_if(
      d.non_manifold_edge_count, WarningCode::kNonManifoldEdges,
      fmt::format("{} {} to more than two triangles, for example where walls meet "
                  "inside; remove inner walls in a mesh editor if no points are wanted "
                  "there",
                  Counted(d.non_manifold_edge_count, "edge"),
                  VerbFor(d.non_manifold_edge_count, "belongs", "belong")));
  warn_if(d.flipped_triangle_count, WarningCode::kFlippedTriangles,
          triangles(d.flipped_triangle_count, "is", "are",
                    "oriented against the neighbours; make the normals consistent in a "
                    "mesh editor if inside and outside matter"));
  warn_if(d.orientable ? 0 : 1, WarningCode::kOneSided,
          "inside and outside cannot be distinguished (1 or more parts are one-sided "
          "like a Moebius strip); points are still made on the surface");
  warn_if(d.inside_out() ? 1 : 0, WarningCode::kInsideOut,
          "the surface is inside out; points are still made on it; flip the normals in a "
          "mesh editor if inside and outside matter");
  warn_if(d.degenerate_triangle_count, WarningCode::kEmptyTriangles,
          triangles(d.degenerate_triangle_count, "has", "have",
                    "no area, and no points are made there"));
  warn_if(d.duplicate_triangle_count, WarningCode::kRepeatedTriangles,
          triangles(d.duplicate_triangle_count, "occurs", "occur",
                    "more than once; remove duplicates in a mesh editor"));
  return warnings;
}

}  // namespace intaglio::mesh
