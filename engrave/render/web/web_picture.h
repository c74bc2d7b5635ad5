#pragma once

// A picture of what a scan head marks on a web: the strokes of each mark, the jumps
// between them in their order, and the field. Seen from above, x along the web to the
// right, y up.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

struct WebPicture {
  std::vector<std::vector<Vec2>> marks_mm;  ///< outline of each, in the order of marking
  std::vector<bool> missed;                 ///< one a mark, or empty
  double field_mm = 0;                      ///< width of the square field
  std::string title;
  std::vector<std::string> figures;  ///< lines below the picture
};

/// Marks from blue (first) to yellow (last), those that are missed red.
Canvas DrawWeb(const WebPicture& picture);

}  // namespace intaglio::render
