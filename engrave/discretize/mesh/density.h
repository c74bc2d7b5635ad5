#pragma once

// How dense the points of a surface are from place to place: 0, the sparsest, to 1, the
// densest. Glass frame, mm.

#include <functional>
#include <memory>

#include "engrave/discretize/mesh/surface_grid.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// Must be a function of the point alone, and may be called from several threads at once.
/// Values outside 0..1 count as the nearer end.
using Density = std::function<double(const SurfacePoint&)>;

/// By place, such as an image that is projected onto the surface: 0..1.
Density DensityByPlace(std::function<double(const Vec3&)> value_at);

/// Dense where the surface bends: 1 where its normal turns by turn_rad (> 0) per
/// millimetre or more, 0 where it is plane.
Density DensityByCurvature(const mesh::TriangleMesh& mesh, double turn_rad_per_mm);

/// As if lit (Lambert 1760): the cosine between the surface's outward normal and the
/// direction that the light comes from, 0 in the shade. Dark is sparse. The direction
/// need not have unit length, but must not be zero.
Density DensityByLight(const mesh::TriangleMesh& mesh, const Vec3& light_from);

/// The spacing for which the number of points for each square millimetre goes from the
/// sparse to the dense one in proportion to the density: so grey values come out right.
double SpacingFor(double density, double dense_mm, double sparse_mm);

}  // namespace intaglio::discretize
