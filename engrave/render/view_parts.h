#pragma once

// The parts of the picture of views.h, and the colours they share.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/views.h"

namespace intaglio::render {

struct Palette {
  Color background_top = Srgb(0x0E1522);
  Color background_bottom = Srgb(0x070A11);
  Color cell = Srgb(0x111B2B);
  Color cell_frame = Srgb(0x24344C);
  Color glass = Srgb(0x3E7FB5);
  Color edge = Srgb(0xA9D9F5);
  Color grid = Srgb(0x6FA3CC);
  Color text = Srgb(0xE6EEF6);
  Color dim_text = Srgb(0x8FA3B8);
  Color beam = Srgb(0x4DFF88);  ///< 532 nm.
  Color good = Srgb(0x53D68A);
  Color bad = Srgb(0xFF6B5E);

  const Color& of(Tone tone) const {
    return tone == Tone::kGood ? good : tone == Tone::kBad ? bad : text;
  }
};

/// The ground of a picture of kViewsWidth x kViewsHeight, its title and its verdict.
void DrawPage(Canvas& canvas, const ViewsCaption& caption);

/// A large cell on the left of a page, and four small ones on the right.
struct PageCells {
  Rect large, top_left, top_right, bottom_left, bottom_right;
};
PageCells CellsOfPage();

/// One of the parallel views: the glass axes that go right and up in it.
struct OrthographicView {
  const char* title;
  const char* from;  ///< The viewing direction as text.
  int right_axis;
  int up_axis;
};

inline constexpr OrthographicView kFromFront{"XZ", "from the front", 0, 2};
inline constexpr OrthographicView kFromRight{"YZ", "from the right", 1, 2};
inline constexpr OrthographicView kFromAbove{"XY", "from above", 0, 1};

/// Pixels per mm at which the block's face of this view fits the cell.
double FittingScale(const Rect& cell, const OrthographicView& view,
                    const Vec3& block_size_mm);

void DrawOrthographicView(Canvas& canvas, const Rect& cell, const OrthographicView& view,
                          double px_per_mm, const PointList& cracks_mm,
                          const Vec3& block_size_mm);

void DrawPerspectiveView(Canvas& canvas, const Rect& cell, const PointList& cracks_mm,
                         const Vec3& block_size_mm);

void DrawFiguresPanel(Canvas& canvas, const Rect& cell,
                      const std::vector<Figure>& figures);

/// The background of a view and its heading: a name, and further text in a dimmer colour.
void DrawCell(Canvas& canvas, const Rect& cell, const std::string& name,
              const std::string& words);

/// A bar of a round length at the right of a view's heading.
void DrawScaleBar(Canvas& canvas, const Rect& cell, double px_per_mm);

/// A length in mm as short as it can be written: "5", "0.2".
std::string ShortNumber(double value);

}  // namespace intaglio::render
