#pragma once

// The side from which a board is machined. Files draw all layers as seen from the front;
// a layer of the back is machined with the board turned over, so that all of the course
// is mirrored about a line along y: copper, holes and outlines alike. Frame: that of the
// files, mm.

#include <optional>
#include <string>

#include "engrave/core/warning.h"
#include "services/job/course/course_files.h"

namespace intaglio {

/// What the files of a course say about it.
struct CourseSide {
  std::string back;  ///< the file that draws the back, for messages; empty: none does
  /// The middle of the board, by its outline: both sides of it have one line.
  std::optional<double> middle_x_mm;
};

/// Mirrors as options.mirror says, by default what draws the back; about
/// options.mirror_x_mm, by default the middle of the board, else 0. `warnings`: a note
/// that has the line, or a warning of a back that is not mirrored. Then adds the holes of
/// options.alignment_y_mm on that line, with a note.
void TurnToSide(const CourseFileOptions& options, const CourseSide& side,
                CourseFiles& files, Warnings& warnings);

}  // namespace intaglio
