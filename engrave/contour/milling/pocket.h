#pragma once

// Pocket clearing: closed paths side by side along the wall of an area, islands in it
// left standing. Frame: drawing, mm.
//
// Pass k runs at r + k s from the wall, r the tool's radius, s the step. Every sixteenth
// pass is made from the wall itself, those between from the one before, so roundings stay
// below 0.02 um. What lies at r + k s .. 2 r + k s
// from the wall is cut by pass k: on the straight way to the nearest place of the wall
// lies a point at r + k s, which is on the pass, and no farther than r. With s <= r these
// ranges join. With s > r a strip at 2 r + k s .. r + (k + 1) s may remain, where pass
// k + 1 does not come near: there a pass at 2 r + k s is put in, from which no point of
// the strip is farther than s - r < r. So what is cut is all that the tool can reach
// without cutting the wall, and nothing else; what remains are inner corners sharper than
// the tool and necks narrower than it.

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
  double left_area_mm2 = 0;        ///< corners and necks, without the allowance
};

/// Where passes would coincide the step is up to a twentieth less than asked for.
/// Errors: kInvalidValue for an option outside its range; kUnsupported when the tool fits
/// nowhere into a part of the area (with its place and the largest diameter that would),
/// or where a proof fails.
Result<Pocket> ClearPocket(const Region& area, const PocketOptions& options);

}  // namespace intaglio::contour
