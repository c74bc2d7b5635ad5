#pragma once

// Plane areas between closed contours of lines and arcs: what one area has beyond
// another, what two have in common, and what lies at least so far inside or outside of
// one. Frame: drawing, mm.
//
// Every result carries a proof by area: of two areas A and B, the parts of A outside and
// inside B are made apart and have to add up to A. What fails it is refused with a place.

#include <span>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/contour/union.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// Closed loops with the area to their left: outer ones run counter-clockwise, those
/// around holes clockwise. They do not cross; they may touch at single places.
struct Region {
  std::vector<Edges> loops;
};

/// What is drawn, as a region: the contours of a union.
Region RegionOf(const Union& drawn);
/// Loops of any direction: inside is what an odd number of them encloses. Errors as of
/// OrientedLoops: kInvalidValue with the place where they cross or touch.
Result<Region> RegionOfLoops(const std::vector<Edges>& loops);

double AreaOf(const Region& region);
bool IsInside(const Region& region, const Vec2& point_mm);

/// a without b, and what both have in common. Errors: kUnsupported where contours nearly
/// touch and the proof by area fails; the sentence names the place.
Result<Region> Difference(const Region& a, const Region& b);
Result<Region> Intersection(const Region& a, const Region& b);

/// The points of the region at least distance_mm from its border (Inset), and those at
/// most distance_mm from the region (Outset): exactly, corners become arcs. 0.0005 ..
/// 5000 mm. Made of the union of what a disc of this radius sweeps along the border, so
/// with its proof; errors as of Unite.
Result<Region> Inset(const Region& region, double distance_mm);
Result<Region> Outset(const Region& region, double distance_mm);

/// What a round tool sweeps along these paths.
Result<Region> Swept(std::span<const Edges> paths, double tool_diameter_mm);

/// Each outer loop with the holes in it, in the order of the outer loops.
std::vector<Region> ConnectedParts(const Region& region);

/// Elements without what `cleared` elements cover, as outlines with the names they have;
/// what `cleared` does not touch is unchanged, what it covers is left out.
Result<std::vector<Element>> Cleared(std::span<const Element> elements,
                                     std::span<const Element> cleared);

}  // namespace intaglio::contour
