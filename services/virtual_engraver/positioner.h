#pragma once

// What the machine's axes do to focus and block: from the axes, where they really are, to
// the place of the focus relative to the block. Written for itself, forwards only: it
// shares nothing with engrave/machine, so that a wrong sign or angle there shows as
// cracks in the wrong place.

#include <array>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::virtual_engraver {

/// A linear guide: what is bolted to its carriage, and whether it was built in backwards.
struct Guide {
  bool carries_block = false;  ///< else the head
  bool backwards = false;
  double travel_ratio = 1;  ///< mm that the carriage moves for 1 mm of its coordinate
  double turn_rad = 0;      ///< of the guide about the vertical, from its proper way
};

/// Where the beam arrives less where it was commanded, at the nodes of a square around
/// the middle of the field, row by row.
struct FieldDeviations {
  double pitch_mm = 1;  ///< > 0
  int nodes = 0;        ///< a side; 0: there are none
  std::vector<Vec2> values_mm;

  /// Linear along x and y between four nodes; beyond the border as at it.
  Vec2 At(const Vec2& commanded_mm) const;
};

/// The machine frame is the laboratory's while all axes are at zero; the block is at
/// BlockInMachine.origin_mm in it then, and goes with what carries it.
struct PositionerOptions {
  /// x, y, z. With an arm, only z; with mirrors x and y have the ways of the beam in the
  /// field in place of a carriage's, and carry nothing.
  std::array<Guide, 3> guides = {};
  /// Arm and turntable in the place of x and y. The turntable's pivot is at the origin of
  /// the laboratory, the arm's on +y. Angles in rad, counterclockwise seen from above;
  /// the arm at zero points to the turntable's pivot.
  bool has_arm = false;
  double pivot_distance_mm = 0;  ///< > 0 with an arm
  double arm_length_mm = 0;      ///< from its pivot to the beam, > 0 with an arm
  /// Two mirrors in the place of x and y: they tilt the beam, whose focus goes over the
  /// field of a lens on the vertical through the origin. Axes 1, 2: mm of the field.
  bool has_mirrors = false;
  Vec2 pupil_mm = Vec2::Constant(1e6);  ///< of the lens, above its focal plane, > 0
  /// The lens puts the beam farther out than commanded by this share at 100 mm, times the
  /// square of the distance.
  double distortion_ratio = 0;
  FieldDeviations deviations;
  /// Under the mirrors, the carriages of the stage that carries the block: x, y.
  std::array<Guide, 2> block_guides = {};
};

/// Where the focus would be in air, in the frame that goes with the block, mm. `axes`:
/// mm, or rad of arm and turntable. `block_mm`: of the stage that carries the block.
Vec3 FocusAt(const PositionerOptions& positioner, const Vec3& axes,
             const Vec2& block_mm = Vec2::Zero());

/// How far the beam goes aside, in x and y, for 1 mm down.
Vec2 BeamSlopes(const PositionerOptions& positioner, const Vec3& axes);

/// How far the focus goes relative to the block when an axis moves by its unit, for the
/// place of the block that is farthest, mm. `block_mm`: the block in the frame that goes
/// with it.
Vec3 FocusPerAxisUnitMm(const PositionerOptions& positioner, const Box3& block_mm);

}  // namespace intaglio::virtual_engraver
