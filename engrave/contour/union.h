#pragma once

// The union of elements grown by a tool's radius: the contours on which the tool's
// centre moves, as exact lines and arcs (after Siwiec 2016, ch. 6.3; the published
// program keeps a fragment when its middle lies in no other element. Here the fragment is
// divided where outlines meet, and a proof runs on every result).
//
// The proof, on every union:
//   - every contour is closed;
//   - three points of every fragment lie in no area, deeper than 2 nm;
//   - where an edge was left out because another runs along it, that one remains, or an
//     area covers the place;
//   - every group of elements that touch has an outer contour.
// What fails it is refused with the place named. Measured on boards of 30 elements with
// nodes moved by 1e-12 .. 1e-3 mm: tests/engrave/contour/moved_nodes_test.cc.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

struct Contour {
  Edges edges;  ///< closed; the union lies to the left: an inner one runs clockwise
  bool inner = false;
  double area_mm2 = 0;  ///< enclosed; negative of an inner contour
  double length_mm = 0;
  std::vector<std::uint32_t> elements;  ///< whose outlines it follows, ascending
};

struct Union {
  std::vector<Contour> contours;
  double area_mm2 = 0;
  /// One number for each element: elements that touch have the same, those that do not
  /// have different ones; counted from 0 in the order of the elements.
  std::vector<std::uint32_t> groups;
  std::uint32_t group_count = 0;
};

struct UnionOptions {
  double tool_radius_mm = 0;  ///< 0 .. 100; on a laser half the kerf
  Corners corners = Corners::kSharp;
  ProgressSink progress = {};  ///< in shares of the work; may be empty
};

/// Contours begin in the order of the elements. Errors name the element and the place:
/// kInvalidValue (a size, a coordinate, an outline that touches itself), kUnsupported
/// (the proof failed: elements nearly but not exactly touch), kCancelled (by progress),
/// kTooLarge (more than 12 million pairs of elements meet or nearly do).
Result<Union> Unite(std::span<const Element> elements, const UnionOptions& options = {});

/// The same contour in the direction of the published programs, where all contours run
/// clockwise, outer and inner ones (Siwiec 2016, annexes B to E).
Edges Clockwise(const Contour& contour);

}  // namespace intaglio::contour
