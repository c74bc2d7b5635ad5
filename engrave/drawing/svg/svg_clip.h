#pragma once

// Clips curves to convex areas: viewports, and clip paths of one rectangle, circle,
// ellipse or convex polygon, which are nearly all that drawing programs write.

#include <memory>
#include <optional>
#include <vector>

#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/svg/svg_path.h"

namespace intaglio::drawing {

/// The piece in the space to which the transform leads.
void ToPage(const SvgTransform& transform, Piece& piece);

/// The box from 0 0 to `size`, likewise.
Curve SvgBoxOf(const SvgTransform& transform, const Vec2& size);

/// Corners of a convex area, counter-clockwise, mm; at least three.
struct ConvexClip {
  std::vector<Vec2> corners_mm;
};

/// The area within a closed curve, when it is convex: flattened to 1 um.
std::optional<ConvexClip> ConvexClipOf(const Curve& curve);

/// The part of the curve within the area. A curve that lies within as a whole stays as it
/// is, exactly. Of another that is `filled` the area is cut, and its outline then follows
/// the clip; of one that is not the line is cut, into several. False: too much work (a
/// limit), the builder has the error.
bool ClipCurve(const Curve& curve, bool filled, const ConvexClip& clip,
               DrawingBuilder& builder, std::vector<Curve>& clipped);

}  // namespace intaglio::drawing
