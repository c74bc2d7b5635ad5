#pragma once

// Isolation of a board: the contours on which a tool cuts its nets apart, in several
// passes side by side.
//
// Pass k runs at r + k s from the copper, r the tool's radius, s the step. What lies at a
// distance d of r + k s .. 2 r + k s from the copper is cut by pass k: on the straight
// way to its nearest copper lies a point at r + k s, which is on the contour, and no
// farther than r. With s <= r these ranges join, so nothing is left between the passes
// however narrow a gap or sharp a corner is: no slivers. With s > r the rest would have
// to be cut by pass k + 1 from outside, which does not exist where two contours have
// merged. So the overlap is at least one half.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/union.h"

namespace intaglio::contour {

struct IsolationOptions {
  double tool_diameter_mm = 0.2;  ///< 0.001 .. 100; of a laser the kerf
  int pass_count = 1;             ///< 1 .. 20
  double overlap_ratio = 0.5;     ///< 0.5 .. 0.95: s = (1 - overlap) * diameter
  ProgressSink progress = {};     ///< in shares of the work; may be empty
};

struct IsolationPass {
  double offset_mm = 0;  ///< of the tool's centre from the copper
  std::vector<Contour> contours;
};

struct Isolation {
  std::vector<IsolationPass> passes;  ///< the nearest to the copper first
  std::uint32_t net_count = 0;        ///< groups of elements that touch
  std::uint32_t piece_count = 0;  ///< that the tool leaves: each has groups of one net
  double width_mm = 0;            ///< that is cut around the copper
};

/// Elements with round corners, so that offsets are distances. Errors as of Unite;
/// besides kInvalidValue for an option outside its range, and kUnsupported when groups
/// that do not have one net's name are nearer to each other than the tool is wide:
/// "cannot isolate A from B: gap 0.18 < tool 0.20", each with its place.
Result<Isolation> Isolate(std::span<const Element> elements,
                          const IsolationOptions& options);

}  // namespace intaglio::contour
