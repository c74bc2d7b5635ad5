#pragma once

// How much of its peak intensity a beam keeps that enters the block at an angle: the face
// splits its focus into two lines (oblique_focus.h), and the same energy makes a weaker
// spot. The peak is that of a sum of plane waves, each refracted at the face by itself
// (scalar; exact for a plane face: E. Wolf, Electromagnetic diffraction in optical
// systems, 1959; P. Török et al., Electromagnetic diffraction of light focused through a
// planar interface, 1995), so spherical aberration and coma are in it, relative to the
// upright beam that is focused to the same depth.

#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::optics {

/// A Gaussian beam behind the lens, and the glass.
struct FocusedBeam {
  double wavelength_mm = 0;       ///< in air, > 0
  double numerical_aperture = 0;  ///< in air: sine of the half angle at 1/e^2, 0.001..0.3
  double refractive_index = 1;    ///< >= 1
};

/// Depth over which an upright beam stays within 1.4 times its width, in the glass, mm:
/// n wavelength / (pi NA^2).
double RayleighRangeMm(const FocusedBeam& beam);

/// Whether both line foci are stronger than the middle between them: then a crack begins
/// at either of two depths, this far apart.
bool HasTwoStrongFoci(const FocusedBeam& beam, double apart_mm);

/// Peak of the oblique beam over that of the upright one, 0..1. `tangent` of the chief
/// ray in air, 0..1; depth of the middle focus >= 0. A few ms.
double ObliquePeakRatio(const FocusedBeam& beam, double tangent, double depth_mm);

/// The same from a table, for each of a million points. A value; constant.
class ObliqueLoss {
 public:
  /// Of 1 / ratio - 1, the energy that has to be added: relative to the sum of plane
  /// waves, where this is above 0.01.
  static constexpr double kMaxExcessError = 0.06;

  /// Up to this depth and tangent, both > 0; beyond them the border holds. Takes 0.1 s or
  /// so.
  ObliqueLoss(const FocusedBeam& beam, double max_depth_mm, double max_tangent);

  double RatioAt(double tangent, double depth_mm) const;
  /// The largest tangent, up to max_tangent, up to which the ratio is at least this,
  /// 0..1.
  double MaxTangent(double depth_mm, double min_ratio) const;

 private:
  double ExcessAt(int depth, int tangent) const;

  double max_depth_mm_, max_tangent_;
  // (1 / ratio - 1) / (tangent depth)^2, which is smooth and stays finite at an upright
  // beam; by depth, then by tangent.
  std::vector<double> excess_;
};

}  // namespace intaglio::optics
