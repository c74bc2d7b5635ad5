#pragma once

// The text of a picture: the title above, and at the right the verdict, the notes, the
// figures and their legend. It is laid out before it is drawn, so that what is written
// where can be checked.

#include <string>
#include <vector>

#include "engrave/render/canvas.h"
#include "engrave/render/text.h"
#include "engrave/render/views.h"

namespace intaglio::render {

struct TextLine {
  Vec2 at_px = Vec2::Zero();  ///< As of DrawText.
  std::string text;
  TextStyle style;
};

/// A filled rectangle, or its outline.
struct Bar {
  Rect rect;
  Paint paint;
  bool outline = false;
};

struct Page {
  Rect views;  ///< Room for the views.
  std::vector<Bar> bars;
  std::vector<TextLine> lines;
};

/// Of a picture of kViewsWidth x kViewsHeight.
Page LayOutPage(const ViewsCaption& caption);

/// The ground of the picture and the page.
void DrawPage(Canvas& canvas, const Page& page);

/// Pixels between the cells of a page.
inline constexpr int kCellGapPx = 14;

}  // namespace intaglio::render
