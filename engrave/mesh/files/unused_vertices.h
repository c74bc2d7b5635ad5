#pragma once

// Vertices of a file that no face has: a sign of faces that were lost, or of points that
// were meant to be seen.

#include <cstdint>
#include <limits>
#include <span>

#include "engrave/core/findings.h"

namespace intaglio::mesh {

/// The index of a vertex of the file that no face has had yet.
inline constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();

/// Adds those that are kUnset, as one finding that names the first and how many vertices
/// there are.
void AddUnusedVertices(std::span<const std::uint32_t> welded, FileFindings& findings);

}  // namespace intaglio::mesh
