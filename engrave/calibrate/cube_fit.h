#pragma once

// What is wrong with a scan head over a block, from the points of a test cube
// (cube_pattern.h) that were measured from the faces of the block: x and y from the faces
// at x = 0 and y = 0, z from the lower face. A coordinate that was not measured is left
// out, and a point that does not belong to the others is, too.
//
// The model has one line more than oblique_focus.h: the face may be tilted. With the
// command f of the mirrors and z of the axis, below = top - z_ratio z the height of the
// face above the focal plane, M = FieldMatrix, tilt (a, b) and lean e,
//   u = M f - e below                  focus in air, from the axis of the lens
//   h = below + a u_x + b u_y          the same below the face
//   t = M f / L - (a, b)               slopes of the beam against the normal of the face
//   q = |t|^2 (1 - 1/n^2),  depth = n h sqrt(1 + q) (1 + q/2),
//   x, y = u - (a, b) below + h t q/2 - origin
// to the first order of tilt and lean: 0.01 rad leave some 10 um in a cube of 50 mm.
// What is determined: z_ratio and n by their product, but for what the beams' angles show
// of n; so one of both has to be known, or the distances of the pupil, which show n where
// beams are oblique (R. Kingslake, Lens Design Fundamentals, ch. 11).

#include <array>
#include <vector>

#include "engrave/calibrate/machine_fit.h"
#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::calibrate {

/// The unknowns; the first are preferred where measurements do not determine all.
enum HeadUnknown {
  kOriginX,  ///< the block's corner from the axis of the lens, mm
  kOriginY,
  kTop,     ///< the block's upper face on that axis, in the frame of z, mm
  kXScale,  ///< of the field, mm for 1 mm
  kYScale,
  kRotation,    ///< of the field, counterclockwise, rad
  kSquareness,  ///< how much less than a right angle + of x and of y enclose, rad
  kZRatio,      ///< how far the focus goes up in air for 1 mm of z; < 0: downward
  kTiltX,       ///< rise of the face for 1 mm of x, and of y
  kTiltY,
  kLeanX,  ///< how far the focus goes aside for 1 mm up
  kLeanY,
  kPupilX,  ///< 1 / distance of the pupil, 1/mm; 0: telecentric
  kPupilY,
  kIndex,  ///< of the glass
  kHeadUnknowns
};
using HeadState = std::array<double, kHeadUnknowns>;

struct CubeMark {
  Vec2 field_mm = Vec2::Zero();  ///< commands, as corrections take them
  double z_mm = 0;               ///< of the axis
  Vec3 measured_mm =
      Vec3::Zero();  ///< glass frame; NaN: this coordinate was not measured
};

struct CubeFrame {
  double block_height_mm = 0;
  /// Depth of the marginal rays' focus over that of the thin pencil, near 1
  /// (optics/focus.h).
  double depth_ratio = 1;
};

/// Where a head makes the mark, glass frame, mm.
Vec3 PlaceOf(const HeadState& head, const CubeMark& mark, const CubeFrame& frame);

/// What is known of the head and not fitted.
enum class KnownOfHead { kIndex, kZ, kPupil };

enum class FigureState {
  kFound,         ///< it differs from what was known
  kAsKnown,       ///< the difference is within its uncertainty
  kUndetermined,  ///< the measurements do not show it; the value is what was known
  kKnown          ///< by KnownOfHead
};

struct HeadFigure {
  Figure figure;  ///< interval95 0: there is none
  FigureState state = FigureState::kKnown;
};

struct CubeFit {
  std::array<HeadFigure, kHeadUnknowns> figures;
  double deviation_mm = 0;  ///< standard deviation of a coordinate
  int coordinate_count = 0;
  std::vector<Vec3> residuals_mm;  ///< one a mark: measured minus fitted; 0: not measured
  std::vector<std::size_t> strays;  ///< marks with a coordinate that does not belong
};

/// Figures whose difference from `known` is within their uncertainty keep what was known,
/// so that the found ones together are what a profile has to have. Errors: kMissing (too
/// few coordinates), kInvalidValue (a command that is no number).
Result<CubeFit> FitCube(const std::vector<CubeMark>& marks, const HeadState& known,
                        const CubeFrame& frame, KnownOfHead held = KnownOfHead::kIndex);

}  // namespace intaglio::calibrate
