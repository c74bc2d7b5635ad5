#pragma once

// The focus of an oblique beam below a flat face: a scan lens over a block of glass.
//
// The command (u, v) is where the chief ray meets the focal plane of the lens in air,
// mm from the axis of the lens; h is how far that plane lies below the top face, in air.
// The chief ray has the slopes u / Lx, v / Ly, where L is the distance of the pupil, by
// axis: the two mirrors have two of them; a telecentric lens has no pupil at a finite
// distance. Refraction splits the focus of a thin pencil into two lines:
//   q = tan^2 (1 - 1/n^2),  c = sqrt(1 + q) = cos(angle in glass) / cos(angle in air)
//   sagittal depth n h c, tangential depth n h c^3,
//   place in their middle x = u + h (u / Lx) q / 2, the same in y
// (Coddington's equations at a plane; R. Kingslake, Lens Design Fundamentals, ch. 11).
// They are exact for a thin pencil; the spherical aberration of a wide one is not in them
// (focus.h, FocusSpreadMm).

#include <limits>
#include <optional>

#include "engrave/core/geometry.h"

namespace intaglio::optics {

/// Distances from the mirrors' image in the lens to the focal plane, mm, > 0; infinite
/// for a telecentric lens.
struct ScanLens {
  Vec2 pupil_mm = Vec2::Constant(std::numeric_limits<double>::infinity());

  bool is_telecentric() const { return pupil_mm.array().isInf().all(); }
  Vec2 SlopesAt(const Vec2& field_mm) const { return field_mm.cwiseQuotient(pupil_mm); }
  /// Tangent of the angle of the chief ray in air.
  double TangentAt(const Vec2& field_mm) const { return SlopesAt(field_mm).norm(); }
};

/// Command and height of the lens's focal plane.
struct HeadPosition {
  Vec2 field_mm = Vec2::Zero();
  double below_face_mm = 0;  ///< h, >= 0

  Vec3 AsVector() const { return {field_mm.x(), field_mm.y(), below_face_mm}; }
};

/// Depths below the face, mm.
struct LineFoci {
  double sagittal_mm = 0, tangential_mm = 0;

  double middle_mm() const { return 0.5 * (sagittal_mm + tangential_mm); }
  double apart_mm() const { return tangential_mm - sagittal_mm; }
};

LineFoci FociOf(const HeadPosition& head, const ScanLens& lens, double refractive_index);

/// The line foci of a beam whose middle focus lies at `depth_mm` and whose chief ray has
/// this tangent in air.
LineFoci FociAtDepth(double depth_mm, double tangent, double refractive_index);

/// Where the chief ray passes the middle of both line foci: x, y from the axis of the
/// lens, and the depth below the face, mm.
Vec3 MiddleFocusOf(const HeadPosition& head, const ScanLens& lens,
                   double refractive_index);

/// Derivative of MiddleFocusOf: rows x, y, depth; columns u, v, h.
Mat3 MiddleFocusSlopes(const HeadPosition& head, const ScanLens& lens,
                       double refractive_index);

struct SolvedPosition {
  HeadPosition head;
  int steps = 0;  ///< of Newton's method
};

/// The inverse of MiddleFocusOf, within `tolerance_mm` of the place, >= 1e-12; depth >=
/// 0. Nothing where the chief ray would be steeper than 45 degrees.
std::optional<SolvedPosition> PositionFor(const Vec3& place_mm, const ScanLens& lens,
                                          double refractive_index,
                                          double tolerance_mm = 1e-12);

}  // namespace intaglio::optics
