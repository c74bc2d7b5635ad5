#pragma once

// How strong the points of a scan head over a block become, and how far from the axis of
// its lens there are cracks: an oblique beam keeps less of its peak intensity the deeper
// its point lies (optics/oblique_intensity.h), and a crack needs that of an upright beam
// of the crack's energy.

#include <optional>

#include "engrave/core/geometry.h"
#include "engrave/optics/oblique_focus.h"
#include "engrave/optics/oblique_intensity.h"

namespace intaglio::machine {

struct BeamStrengthOptions {
  optics::FocusedBeam beam;
  optics::ScanLens lens;
  double field_mm = 0;  ///< from the axis of the lens to the corner of its field, > 0
  double crack_energy_mj = 0;  ///< the least that makes a crack with an upright beam, > 0
  /// Of the points below the face, > 0; beyond it that of this depth holds.
  double max_depth_mm = 0;
};

/// Places are relative to the axis of the lens, mm; depths below the face, mm, >= 0. A
/// value; constant. It takes a second or less to make, and each call some 0.1 us.
class BeamStrength {
 public:
  explicit BeamStrength(const BeamStrengthOptions& options);

  /// How far from the axis a pulse of this energy makes a crack, in every direction of
  /// the field, mm: the usable radius at a depth. 0: nowhere.
  double UsableRadiusMm(double depth_mm, double energy_mj) const;
  /// Beyond this radius both line foci are stronger than what lies between them.
  double DoubleRadiusMm(double depth_mm) const;

  /// Tangent of the beam to a place, in air. A place that no beam reaches has 1.
  double TangentTo(const Vec2& from_axis_mm, double depth_mm) const;
  /// Peak intensity of the beam over that of an upright one, 0..1.
  double RatioAt(double tangent, double depth_mm) const;
  /// How many times the energy of an upright beam makes a point as strong, >= 1. The
  /// error of the table is added, so it is never too little.
  double EnergyTimes(double tangent, double depth_mm) const;
  /// Distance of both line foci in depth, mm.
  double ApartMm(double tangent, double depth_mm) const;
  /// A crack may begin at either of two depths.
  bool IsDouble(double tangent, double depth_mm) const;

  const BeamStrengthOptions& options() const { return options_; }

 private:
  double RadiusMm(double depth_mm, double tangent) const;

  BeamStrengthOptions options_;
  double max_tangent_;
  std::optional<optics::ObliqueLoss> loss_;  ///< absent: every beam is upright
};

}  // namespace intaglio::machine
