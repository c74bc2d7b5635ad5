#pragma once

// Where the focus is in the glass, and how wide the beam is above it.
//
// Light refracts at the block's flat top face, so a stage move moves the focus by more
// than itself: for the focus to be at depth d below the face the stage moves
// d * StagePerGlassRatio, about d / n (Trochimczuk 2008 ch. 5, turned round, and exact
// for the marginal ray). machine_frame.h applies it.
//
// Ranges, checked always (they throw): refractive index n >= 1, 0 < numerical aperture
// < 1.

namespace intaglio::optics {

struct Lens {
  double focal_length_mm = 0;
  double numerical_aperture = 0;  ///< in air, sine of the cone's half angle
};

/// Stage move for a focus move in the glass so that the marginal rays meet there:
/// sqrt(1 - NA^2) / sqrt(n^2 - NA^2), in (0, 1].
double StagePerGlassRatio(double refractive_index, double numerical_aperture);

/// The index that a StagePerGlassRatio of this aperture belongs to.
double RefractiveIndexOf(double stage_per_glass_ratio, double numerical_aperture);

/// How far above the focus of the marginal rays those near the beam's axis meet, at a
/// depth d >= 0 of the former: d (1 - n StagePerGlassRatio), mm. The flat top face
/// spreads the focus in proportion to the depth; a beam that does not fill the lens has
/// less.
double FocusSpreadMm(double refractive_index, double numerical_aperture, double depth_mm);

/// Tangent of the half angle of the converging cone in the glass, NA / sqrt(n^2 - NA^2):
/// a crack above a point, within this times the height difference of it, scatters the
/// pulse.
double ConeTangentInGlass(double refractive_index, double numerical_aperture);

}  // namespace intaglio::optics
