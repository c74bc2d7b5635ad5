#pragma once

#include <cstdint>
#include <vector>

#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

inline constexpr std::uint32_t kNoNeighbour = 0xffffffff;
/// Far above what an import lets in; half-edges times 4 still fit 32 bits.
inline constexpr std::size_t kMaxNeighbourTriangles = std::size_t{1} << 28;

/// Half-edges are numbered 3 * triangle + side, side i from corner i to corner i + 1.
/// For each, the half-edge of another triangle on the same edge, or kNoNeighbour at an
/// open edge. On an edge of more than two triangles they are paired, opposite directions
/// first; an odd one is left open. Neighbourhood is mutual. A triangle with a repeated
/// corner has no part in it. Linear time.
std::vector<std::uint32_t> EdgeNeighbours(const mesh::TriangleMesh& mesh);

}  // namespace intaglio::discretize
