#pragma once

// Pocket clearing: closed paths side by side along the wall of an area, islands in it
// left standing. Frame: drawing, mm.
//
// Pass k runs at r + k s from the wall, r the tool's radius, s the step. Each is made
// from the one before: what is at least s from it, inside of it. Of what lies inside of
// pass k that pass cuts all that is at most r from it. With s <= r pass k + 1 lies within
// that, or there is nothing farther inside: so nothing is left between them. With s > r a
// strip beyond r may remain, where pass k + 1 does not come near: there a pass at r from
// pass k is put in, from which no point of the strip is farther than s - r < r. So what
// is cut is all that the tool can reach without cutting the wall, and nothing else; what
// remains are inner corners sharper than the tool and necks narrower than it. None of
// this compares a pass with more than its neighbours, and none of it needs pass k to be
// exactly at r + k s.
//
// An outline of more than 256 edges (a zone of a layout program, divided curves) and the
// passes made from it are simplified by a tolerance t = 0.002 mm, or a hundredth of the
// step where that is less. Then the first pass is r to r + 2 t from the wall and cuts
// nothing outside, and each other one is s - 2 t to s from the one before: as in the rule
// above, whose offsets are not exact. What stays uncut for that is at most 2 t from the
// wall, or from what the tool cannot reach. Of fewer edges every sixteenth pass is made
// from the wall itself, so that roundings stay below 0.02 um.

#include <vector>

#include "engrave/contour/region/region.h"

namespace intaglio::contour {

struct PocketOptions {
  double tool_diameter_mm = 1;  ///< 0.001 .. 100
  double step_ratio = 0.45;     ///< s as a part of the diameter, 0.05 .. 0.95
  double allowance_mm = 0;      ///< left on the wall, 0 .. 10
  int max_pass_count = 10'000;  ///< beyond it: kTooLarge
};

struct PocketPass {
  double offset_mm = 0;      ///< of the tool's centre from the wall, with the allowance
  bool between = false;      ///< put in where a step wider than the radius left a strip
  std::vector<Edges> paths;  ///< closed, what is farther from the wall to the left
};

struct Pocket {
  std::vector<PocketPass> passes;  ///< in the order of milling: along the wall last
  double cut_area_mm2 = 0;         ///< what the tool sweeps: all of it is in the area
  /// Corners and necks, without the allowance; along the length of the walls to t.
  double left_area_mm2 = 0;
  double tolerance_mm = 0;  ///< 2 t, or 0: passes are at their offsets exactly
};

/// Where passes would coincide the step is up to a twentieth less than asked for.
/// Errors: kInvalidValue for an option outside its range; kUnsupported when the tool fits
/// nowhere into a part of the area (with its place and the largest diameter that would),
/// or where a proof fails.
Result<Pocket> ClearPocket(const Region& area, const PocketOptions& options);

}  // namespace intaglio::contour
