#pragma once

// Static stiffness of a positioner at the focus, in the plane across the beam.
//
// Source: Trochimczuk 2008, ch. 9: c = c1 c2 / (c1 + c2) of screw drives in series (136),
// c = c1 = c2 of a planar drive (137), c = c1 + c2 of arm and table "in parallel" (138).
// The last does not hold: the force between tool and piece passes through the arm and
// through the table, so what each yields adds up, too. WeakestStiffness has it for any
// positioner from its kinematics: with axis i of stiffness k_i and the move J_i of the
// focus for a unit of it, a force F at the focus moves it by sum J_i J_i^T / k_i F
// (Salisbury 1980).

#include "engrave/core/geometry.h"
#include "engrave/machine/kinematics.h"

namespace intaglio::machine {

enum class StiffnessRule {
  kSeries,       ///< (136)
  kIndependent,  ///< (137); of two that differ the lower
  kParallel,     ///< (138)
};

/// As the source has it; both > 0, in one unit, which is the result's.
double SourceStiffness(StiffnessRule rule, double first, double second);

/// Smallest and greatest move of the focus in the plane for a vector of length one of the
/// first two axes, mm.
struct PlaneScale {
  double min_mm = 0, max_mm = 0;
};
PlaneScale PlaneScaleAt(const Kinematics& kinematics, const Vec3& axes);

/// Force over deflection in the weakest direction of the plane, N/mm. `stiffness` of the
/// first two axes: N/mm, or N mm/rad of one that turns; > 0.
double WeakestStiffness(const Kinematics& kinematics, const Vec3& axes,
                        const Vec2& stiffness);

}  // namespace intaglio::machine
