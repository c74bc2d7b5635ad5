#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/files/corner_welder.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// Triangles given by the coordinates of their corners become a welded mesh.
class TriangleWelder {
 public:
  /// For about `expected_triangle_count` triangles of a closed surface, which has half as
  /// many vertices.
  TriangleWelder(const ImportSource& source, std::size_t expected_triangle_count);

  /// kTooLarge and kInvalidValue as ImportMeshFromMemory() has them. An error may be
  /// reported only after some more triangles.
  Status Add(const std::array<CornerWelder::Corner, 3>& triangle) {
    corners_.insert(corners_.end(), triangle.begin(), triangle.end());
    return corners_.size() < kBatch ? Status() : Flush();
  }

  /// Nothing may be added afterwards.
  Result<TriangleMesh> Take();

 private:
  static constexpr std::size_t kBatch = 3 * 4096;

  Status Flush();

  const ImportSource& source_;
  CornerWelder welder_;
  std::vector<CornerWelder::Corner> corners_;
  std::vector<std::uint32_t> indices_;
  std::vector<Triangle> triangles_;
};

}  // namespace intaglio::mesh
