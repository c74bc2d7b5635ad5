#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::discretize {

/// Points with the distance that each keeps from the others of its own source. The
/// candidates that the methods give to thinning, and the points that it keeps. Structure
/// of arrays of equal length, glass frame, mm.
struct SpacedCloud {
  PointList points_mm;
  std::vector<std::uint32_t> source;  ///< model of the job a point came from
  std::vector<float> spacing_mm;      ///< 0: the minimum spacing of the block alone

  std::size_t size() const { return points_mm.size(); }
  void Add(const Vec3& p_mm, std::uint32_t source_index, float own_spacing_mm = 0) {
    points_mm.push_back(p_mm);
    source.push_back(source_index);
    spacing_mm.push_back(own_spacing_mm);
  }
  /// New points, if any, are zero.
  void Resize(std::size_t count) {
    points_mm.resize(count, Vec3::Zero());
    source.resize(count);
    spacing_mm.resize(count);
  }
};

}  // namespace intaglio::discretize
