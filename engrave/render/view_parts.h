#pragma once

// The parts of the pictures of views.h and spacing_map.h, and the colours they share.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/views.h"
#include "engrave/render/views_layout.h"

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
  Color warning = Srgb(0xFFC24A);
  Color bad = Srgb(0xFF6B5E);

  const Color& of(Tone tone) const {
    return tone == Tone::kGood      ? good
           : tone == Tone::kWarning ? warning
           : tone == Tone::kBad     ? bad
                                    : text;
  }
};

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

/// Of a parallel view.
constexpr const OrthographicView& ViewOf(PanelKind kind) {
  return kind == PanelKind::kFromFront   ? kFromFront
         : kind == PanelKind::kFromRight ? kFromRight
                                         : kFromAbove;
}

/// Pixels that a parallel view has across and up in a cell.
Vec2 RoomIn(const Rect& cell);
/// Pixels per mm at which a box of this size fits the cell in this view.
double FittingScale(const Rect& cell, const OrthographicView& view, const Vec3& size_mm);
/// The same in perspective, in the middle of the box.
double PerspectiveScale(const Rect& cell, const Box3& box_mm);

void DrawOrthographicView(Canvas& canvas, const Panel& panel, const PointList& cracks_mm);
void DrawPerspectiveView(Canvas& canvas, const Panel& panel, const PointList& cracks_mm);

/// The background of a view and its heading: a name, and further text in a dimmer colour.
void DrawCell(Canvas& canvas, const Rect& cell, const std::string& name,
              const std::string& description);

/// StatusOf, at the lower right of a view.
void DrawStatus(Canvas& canvas, const Panel& panel);

/// A bar of a round length at the right of a view's heading.
void DrawScaleBar(Canvas& canvas, const Rect& cell, double px_per_mm);

/// The step of a grid: the one that is asked for, or, where that is 0, the chosen one. A
/// step that would make more than 500 lines in the range is multiplied.
double GridStep(double asked_mm, double chosen_mm, double range_mm);

/// Of a perspective view, or one from a camera, in its middle.
double MiddleScale(const Panel& panel);

/// The step of the grid on the floor of a perspective view.
double FloorStep(const Box3& box_mm, double asked_mm);
/// The step of a panel's finest grid, mm.
double GridStepOf(const Panel& panel);

/// Grid and scale of a panel: "grid 5 mm, 12.4 pixels a mm"; in perspective the scale is
/// that of the middle.
std::string StatusOf(const Panel& panel);

/// "33 x 31 x 22 mm", with four digits each.
std::string SizeNumbers(const std::vector<double>& sizes_mm);

/// A length in mm as short as it can be written: "5", "0.2".
std::string ShortNumber(double value);

}  // namespace intaglio::render
