#pragma once

// A picture of contours that were cut at speed: the path with the deviation of the actual
// course, many times larger than it is, and below it the speed along the path. Seen from
// above, x to the right, y up.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

/// One place of the actual course, in the order of time.
struct CourseSample {
  Vec2 place_mm = Vec2::Zero();  ///< nearest place of the path
  Vec2 by_mm = Vec2::Zero();     ///< from there to the actual point
  double s_mm = 0;               ///< arc length of the place, of all contours together
  double speed_mm_s = 0;
};

struct CoursePicture {
  std::vector<std::vector<Vec2>> paths_mm;         ///< nodes of each contour
  std::vector<std::vector<CourseSample>> courses;  ///< of each contour
  double tolerance_mm = 0;
  std::string title;
  std::vector<std::string> figures;  ///< lines below the picture
};

/// How much larger deviations are drawn: a round number (1, 2 or 5 times a power of ten)
/// so that the tolerance is a fortieth of the contours' extent or less, 1 or more.
double CourseMagnification(const CoursePicture& picture);

Canvas DrawCourse(const CoursePicture& picture);

}  // namespace intaglio::render
