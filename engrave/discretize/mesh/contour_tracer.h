#pragma once

// The contours in which planes cut a mesh. Frame glass, mm.

#include <cstdint>
#include <functional>
#include <vector>

#include "engrave/discretize/spacing/interval_index.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// Planes at equal distances, by their height along their normal.
struct PlaneStack {
  double origin_mm = 0;
  double pitch_mm = 1;
  double first_step = 0;  ///< a whole number: pitches from the origin to the first plane
  std::uint32_t count = 0;

  double HeightOf(std::uint32_t plane) const {
    return origin_mm + (first_step + static_cast<double>(plane)) * pitch_mm;
  }
  /// How many planes are at this height or below.
  std::uint32_t RankOf(double height_mm) const;
};

struct Contour {
  std::size_t begin = 0, end = 0;  ///< in Contours::points_mm
  std::uint32_t plane = 0;
  bool closed = false;
};

/// Contours, one after another. A closed one begins and ends in the same point: the one
/// foremost along the planes' u axis, so that the seams of neighbouring planes lie
/// together.
struct Contours {
  PointList points_mm;
  std::vector<double> arc_mm;  ///< of each point, from its contour's beginning
  std::vector<Contour> list;

  void Clear() {
    points_mm.clear();
    arc_mm.clear();
    list.clear();
  }
};

class ContourTracer {
 public:
  /// `frame`: columns u, v, w, the planes lie across the last. `rank`: of each vertex,
  /// the planes up to it. `neighbours`: EdgeNeighbours(mesh).
  ContourTracer(const mesh::TriangleMesh& mesh, std::vector<std::uint32_t> rank,
                const std::vector<std::uint32_t>& neighbours, const Mat3& frame,
                const PlaneStack& planes);

  /// Appends the contours of the planes in the range and calls `visit` after every plane,
  /// until it returns false. The contours of a plane depend on that plane alone. A plane
  /// passes below a vertex that lies exactly in it, so every contour of a closed mesh is
  /// closed. May be called from several threads at once.
  void Trace(const Interval& planes, Contours& contours,
             const std::function<bool(std::uint32_t plane)>& visit) const;

  /// Points of all contours together.
  std::uint64_t crossing_count() const { return crossing_count_; }

 private:
  class Sweep;
  // Half-edges are numbered 4 * triangle + side here: no division on the way.
  struct Facet {
    std::uint32_t corner[3];
    std::uint32_t across[3];
  };
  struct Corner {
    Vec3 p_mm;
    double height_mm;  // along the normal
  };

  PlaneStack planes_;
  Vec3 u_axis_, v_axis_;
  bool level_;  // the planes lie across z: heights are z, exactly
  std::vector<Corner> corners_;
  std::vector<std::uint32_t> rank_;  // of each corner
  std::vector<Facet> facets_;
  std::uint64_t crossing_count_ = 0;
  IntervalIndex cut_planes_;  // of each triangle
};

}  // namespace intaglio::discretize
