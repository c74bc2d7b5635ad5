#pragma once

// The comparison of what the tool of a mill or of a laser cutter did with the marks of
// its job: each mark by the steps along it, and the sheet by what was cleared of it.
// Frame: the machine's axes as they were at the power-up, which is that of the marks.
//
// The judge is the machine's own record: neither the journal nor the program is used.
// Time: cells that the tool sweeps, three times; places of the marks.

#include <cstdint>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/formats/tool_way.h"
#include "engrave/mark/mark.h"
#include "engrave/proof/cut_sheet.h"
#include "engrave/proof/mark_comparison.h"

namespace intaglio::proof {

/// What was cleared beside what was planned. A difference counts beyond the tolerance.
struct CutFigures {
  double cell_mm = 0;
  /// Of the uncut face: pieces wider than twice the tolerance.
  std::uint32_t pieces_planned = 0, pieces_left = 0;
  std::uint32_t pieces_joined = 0;  ///< planned pieces that hang together with another
  std::uint32_t pieces_split = 0;   ///< planned pieces that are several
  double cleared_mm2 = 0;
  double beside_mm2 = 0;    ///< cleared beside the plan
  double uncut_mm2 = 0;     ///< left of the plan
  double too_deep_mm2 = 0;  ///< deeper than the plan
  double through_mm2 = 0;   ///< cut through where the plan is not, or may not
  double deepest_mm = 0;
  double stray_mm = 0;          ///< way at work beside all marks
  double idle_in_sheet_mm = 0;  ///< way in the sheet while the spindle was at rest
  double work_s = 0;            ///< from the first step at work to the last
};

struct CutComparison {
  MarkComparison marks;  ///< place, shape and fate of each; no gap, diameter or energy
  CutFigures figures;
  CutSheet sheet;                    ///< as it is left
  std::vector<CutStep> sheet_steps;  ///< of the tool, below the face where it was at work
};

/// What the job is made with.
struct CutPlan {
  double tool_diameter_mm = 0;  ///< > 0
  bool may_cut_through = true;  ///< where its marks are so deep
  double tolerance_mm = 0.02;   ///< of places and depths
};

/// `set` passes CheckMarks. kTooLarge: a sheet of too many cells.
Result<CutComparison> CompareCuts(const mark::MarkSet& set, const CutPlan& plan,
                                  const formats::ToolWay& way);

}  // namespace intaglio::proof
