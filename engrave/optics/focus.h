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

/// The same for rays near the axis: 1 / n.
double ParaxialStagePerGlassRatio(double refractive_index);

/// Stage move below the place where the focus is on the top face, for a depth of the
/// marginal focus below that face; and back.
double StageDepthForFocus(double depth_in_glass_mm, double refractive_index,
                          double numerical_aperture);
double FocusDepthForStage(double stage_depth_mm, double refractive_index,
                          double numerical_aperture);

/// Half angle of the converging cone in the glass: asin(NA / n).
double ConeHalfAngleInGlassRad(double refractive_index, double numerical_aperture);

/// Its tangent, NA / sqrt(n^2 - NA^2): a crack above a point, within this times the
/// height difference of it, scatters the pulse.
double ConeTangentInGlass(double refractive_index, double numerical_aperture);

/// Spherical aberration of the face: by how much the focus of the rays near the axis lies
/// above that of the marginal rays when the latter is at this depth; >= 0, grows with the
/// depth. Compare it with the crack's length (0.1-0.8 mm) to warn.
double FocusSpreadAtDepthMm(double depth_in_glass_mm, double refractive_index,
                            double numerical_aperture);

}  // namespace intaglio::optics
