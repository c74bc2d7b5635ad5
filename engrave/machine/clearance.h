#pragma once

// Whether what hangs around the beam meets what lies on the table: lens and head against
// the block and what is fixed beside it.
//
//        |   head   |     bodies: upright cylinders around the beam, without an upper end
//        |__________|
//           |lens|
//           |____|        lowest face: bottom_above_focus_mm above the focus in air
//             \/
//    ______    x focus in air
//    |solid|              solids: boxes along the machine frame
//
// Light is refracted at the top face, so for a focus at the depth d the head goes
// d * k deep, k = optics::StagePerGlassRatio: the lens meets the block when d * k is
// above its distance from the focus, which is at most the focal length: at f / k, which
// is 65 mm for f = 43 mm and 106 mm for f = 70 mm in N-BK7 (Trochimczuk 2008 annex D:
// objects of over 60 mm and blocks of over 100 mm).
//
// All lengths in mm. Frame: that of the focus, optics::MachineFromGlass::ToMachine.

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::machine {

struct BeamBody {
  double bottom_above_focus_mm = 0;  ///< finite
  /// Around the beam, >= 0; infinite: wider than all that is on the table.
  double radius_mm = std::numeric_limits<double>::infinity();
};

struct Collision {
  std::size_t body = 0, solid = 0;  ///< their places in the lists
  double overlap_mm = 0;            ///< how far the body would have to be raised, > 0
  Vec3 focus_mm = Vec3::Zero();     ///< in air, where the overlap is greatest
};

class Clearance {
 public:
  /// Boxes may be infinite, and are not empty. Throws otherwise, and for a body that is
  /// no number.
  Clearance(std::vector<BeamBody> bodies, std::vector<Box3> solids);
  /// Nothing meets anything.
  Clearance() = default;

  /// With the focus at this place; the deepest overlap.
  std::optional<Collision> At(const Vec3& focus_mm) const {
    return Along(focus_mm, focus_mm);
  }
  /// Anywhere on the straight way between both; the deepest overlap. Touching is none.
  std::optional<Collision> Along(const Vec3& from_mm, const Vec3& to_mm) const;

 private:
  std::vector<BeamBody> bodies_;
  std::vector<Box3> solids_;
};

}  // namespace intaglio::machine
