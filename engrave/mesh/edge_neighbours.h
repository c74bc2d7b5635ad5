#pragma once

#include <cstdint>
#include <vector>

#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

inline constexpr std::uint32_t kNoNeighbour = 0xffffffff;

/// For each half-edge, by its number (half_edges.h), the half-edge of another triangle on
/// the same edge, or kNoNeighbour at an open edge. On an edge of more than two triangles
/// they are paired, opposite directions first; an odd one is left open. Neighbourhood is
/// mutual. A triangle with a repeated corner has no part in it. Linear time.
std::vector<std::uint32_t> EdgeNeighbours(const TriangleMesh& mesh);

}  // namespace intaglio::mesh
