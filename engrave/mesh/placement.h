#pragma once

// The transform of a model from its file (model frame, file units) into the block (glass
// frame, mm, the block spans [0, size], z up). Applied in this order:
//   1. unit      file units to mm
//   2. up        the file's up axis becomes z (up_axis.h)
//   3. mirror    across the planes x = 0, y = 0, z = 0 of the upright model
//   4. scale     along each axis of the upright model
//   5. rotate    about the fixed axes x, then y, then z: R = Rz Ry Rx
//   6. fit       one factor for all axes, from the size that steps 1 to 5 gave
//   7. centre    equal distance from the outermost points to opposite walls
//   8. move      a shift in the glass frame, after centring if there is any
//   9. turn      with the block, by right angles about z
// Without centring the model frame's origin lies at the block's origin before step 8;
// steps 3 to 6 leave the pivot, a point of the glass frame, in its place. A mirrored
// model's triangles get their corners reversed, so faces still point outward.

#include <variant>

#include "engrave/core/result.h"
#include "engrave/mesh/mesh.h"
#include "engrave/mesh/up_axis.h"

namespace intaglio::mesh {

struct NoFit {};
/// The height, along z, becomes this.
struct FitHeight {
  double height_mm = 0;
};
/// The largest of the three extents becomes this.
struct FitLargest {
  double size_mm = 0;
};
/// The model becomes as large as it can be within a box of this size, e.g. the block
/// minus its margin on both sides.
struct FitBox {
  Vec3 size_mm = Vec3::Zero();
};
using Fit = std::variant<NoFit, FitHeight, FitLargest, FitBox>;

/// The fixed point of mirror, scale, turn and fit.
enum class Pivot {
  kOrigin,  ///< of the model frame
  kObject,  ///< the centre of the upright model's extent, before it is mirrored
  kBlock,   ///< the centre of the block
};

struct Placement {
  /// mm that a file unit is long; positive. Default: the file is in mm. 25.4 for inches,
  /// 1000 for metres.
  double unit_mm = 1;
  UpAxis up = UpAxis::kZ;  ///< of the file
  bool mirror_x = false;
  bool mirror_y = false;
  bool mirror_z = false;
  Vec3 scale_ratio = Vec3::Ones();   ///< each positive
  Vec3 rotation_rad = Vec3::Zero();  ///< angles about x, then y, then z, fixed axes
  Fit fit = NoFit{};                 ///< sizes positive
  Vec3 move_mm = Vec3::Zero();       ///< glass frame
  bool centre_in_block = true;
  Pivot pivot = Pivot::kOrigin;  ///< without a meaning when centred
  /// The block was turned so often by a right angle, counterclockwise from above, 0..3.
  /// Steps 6 to 8 are those in the block before, which is as wide as this one is deep
  /// after an odd number.
  int quarter_turns = 0;
};

/// Counterclockwise from above, 0..3.
Mat3 QuarterTurnsAboutZ(int count);

/// Of the block before it was turned `quarter_turns` times.
Vec3 SizeBeforeTurns(const Vec3& block_size_mm, int quarter_turns);

/// The axes of the model in the glass frame, columns: step 5, and the turns of the block.
Mat3 ObjectAxesOf(const Placement& placement);

/// About the fixed axes x, then y, then z; exact where an angle is a multiple of a right
/// angle, so that a box stays a box.
Mat3 RotationOf(const Vec3& rotation_rad);

/// p_glass = linear * p_model + offset_mm.
struct GlassFromModel {
  Mat3 linear = Mat3::Identity();
  Vec3 offset_mm = Vec3::Zero();

  Vec3 Apply(const Vec3& p_model) const { return linear * p_model + offset_mm; }
};

/// The transform of the placement for these vertices (their extent decides fit and
/// centre). Errors, kInvalidValue: a fit to a height or size that the model does not
/// have (a flat model fitted to a height), or a result that is not finite. Broken
/// preconditions: no vertices, or option values outside the ranges above.
Result<GlassFromModel> GlassFromModelOf(const PointList& vertices,
                                        const Placement& placement,
                                        const Vec3& block_size_mm);

/// The mesh in the glass frame, mm. Errors as above. It may extend beyond the block: the
/// check of the points reports that.
Result<TriangleMesh> PlaceInBlock(const TriangleMesh& mesh, const Placement& placement,
                                  const Vec3& block_size_mm);

}  // namespace intaglio::mesh
