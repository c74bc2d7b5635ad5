#pragma once

// Slots of drill files and boards: milled along curves, or drilled as rows of holes.
// Frame: that of the files, mm.
//
// A row of holes of diameter d leaves cusps on both sides of the slot. Neighbours p apart
// meet at sqrt(d^2 - p^2) / 2 from the line of their centres, so a cusp is
// (d - sqrt(d^2 - p^2)) / 2 high: at most d / 20 with p of at most 0.435 d. On an arc of
// radius R over an angle a from hole to hole it is, outside,
// R + d / 2 - R cos(a / 2) - sqrt(d^2 / 4 - R^2 sin^2(a / 2)).
//
// A drill with a hole on one side of it wanders there. So the ends are drilled first,
// then every fourth hole, then those in the middle between two, twice; of the tool's
// other slots the same ones in the same turn. The parts of a slot are 1, 2 or a multiple
// of 4: of a line with 12 or more every fourth hole is 1.1 d from the next. A slot
// shorter than d has its second end beside the first.

#include <string>
#include <vector>

#include "services/job/course/course_files.h"

namespace intaglio {

/// Adds `slots` (tracks and arc tracks as wide as their tool) of the file to `files`, and
/// a note that has the figures to `warnings`. A course along curves mills them: on their
/// middle where the tool is as wide, else along their wall; a course of another kind
/// drills rows of holes. Slots that are narrower than the tool, and those of a laser that
/// does not follow curves, are left out with a warning. Errors: kTooLarge, more than
/// 1 000 000 holes; as of Unite.
Status AddSlots(const Course& course, const std::string& file,
                const std::vector<contour::Element>& slots, CourseFiles& files,
                Warnings& warnings);

}  // namespace intaglio
