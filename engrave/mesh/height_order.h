#pragma once

#include <cstdint>
#include <vector>

#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// Renumbers vertices by their rank, and triangles by the lowest of their corners', in
/// place; `rank` (of each vertex, below rank_count) with them. The triangles of a plane
/// or a slab are then contiguous in memory, whatever the order in the file. Linear time;
/// where there are more ranks than vertices, the order is correct except among near
/// ranks.
void OrderByRank(TriangleMesh& mesh, std::vector<std::uint32_t>& rank,
                 std::uint32_t rank_count);

}  // namespace intaglio::mesh
