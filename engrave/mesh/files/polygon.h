#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::mesh {

/// Triangles of a polygon, as indices of its corners, n - 2 of them in its own sense of
/// rotation: a fan for a convex one, ears (Meisters 1975, "Polygons have ears") for
/// others, in the plane of its area vector (Newell). The area of the triangles is that of
/// the polygon, which is checked: nothing when they differ by more than 1 part in 10^6 (a
/// polygon that crosses itself), with a fan for a polygon without an area. At most
/// kMaxPolygonCorners corners that are not convex.
inline constexpr std::size_t kMaxPolygonCorners = 20'000;
std::optional<std::vector<std::array<std::size_t, 3>>> TriangulatePolygon(
    std::span<const Vec3> corners);

}  // namespace intaglio::mesh
