#pragma once

// How the beams of a scan head lean in the block below it. A beam comes to its place from
// the pupil of the lens: going up it leans towards the axis of the lens, less in the
// glass than in air.
//
// With the chief ray's slopes in air t = (u / Lx, v / Ly), q = t^2 (1 - 1/n^2) and
// c = sqrt(1 + q), the slopes in the glass are t / (n c) (optics/oblique_focus.h, whose
// symbols these are). The command (u, v) of a place (x, y) at the depth d is
//   u = x / (1 + h q / (2 Lx)), h = d / (n c (1 + q / 2)),
// of which some steps from (x, y) on are made: within 1e-6 of the slope.

#include "engrave/core/geometry.h"

namespace intaglio::sort {

struct BeamLean {
  Vec2 pupil_mm = Vec2::Ones();  ///< distances by axis, > 0; infinite: upright
  Vec2 axis_mm = Vec2::Zero();   ///< of the lens, in the frame of the points
  double top_mm = 0;             ///< z of the face; above it the beam is in air
  double refractive_index = 1;   ///< >= 1
  /// No place is farther from the axis, >= 0.
  double widest_mm = 0;
  /// Depth in the glass for a mm of z of the points' frame: 1 in the frame of the glass.
  double depth_ratio = 1;

  /// How far the axis of the beam to `place_mm` moves across for each mm up.
  Vec2 UpwardAt(const Vec3& place_mm) const;
  /// No beam to a place up to widest_mm from the axis leans more.
  double Steepest() const;
};

}  // namespace intaglio::sort
