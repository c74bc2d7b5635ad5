#pragma once

// A scan head: two mirrors and a lens, from the mirrors' angles to the place of the focus
// and back.
//
// Angles are optical (twice the mechanical), rad, (x, y); places are in the frame field,
// mm, origin at the undeflected beam.
//   Lens behind the mirrors (f-theta): the beam leaves the mirrors in the direction
//     (sin ax cos ay, sin ay, cos ax cos ay); the lens puts it at the height
//     h = f1 t + f2 t^2 + f3 t^3 + f4 t^4 of its angle t to the axis. The mirror nearer
//     the laser deflects y, as in the correction files that are published with such
//     polynomials (files/ct5.h).
//   Lens before the mirrors: x = (D / cos ay + e) tan ax, y = D tan ay (Bessmeltsev,
//     Goloshevsky, Smirnov 2009, (1), corrected: it has 1 in place of e, and divides
//     by the cosine of the angle as optical). The mirror nearer the laser deflects x.

#include <array>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::galvo {

enum class LensPlace { kBehindMirrors, kBeforeMirrors };

struct Head {
  LensPlace lens = LensPlace::kBehindMirrors;
  /// f1..f4 of a lens behind the mirrors, mm per rad, rad^2, ...; f1 > 0.
  std::array<double, 4> heights_mm{};
  double distance_mm = 0;    ///< D of a lens before them: second mirror to the field, > 0
  double mirror_gap_mm = 0;  ///< e of a lens before them: between the mirrors, >= 0
};

/// kInvalidValue: a number outside its range, with its name.
Status CheckHead(const Head& head);

/// Where the beam meets the field. `head` as of CheckHead; angles below a right angle.
Vec2 FieldOf(const Vec2& angles_rad, const Head& head);

/// The angles that put the beam there, to 1e-12 of the place. kInvalidValue: no angle
/// below a right angle does, as the lens has no such height.
Result<Vec2> AnglesFor(const Vec2& place_mm, const Head& head);

}  // namespace intaglio::galvo
