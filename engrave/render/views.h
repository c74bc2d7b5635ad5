#pragma once

// The picture of an engraved block: three parallel views (XY from above, XZ from the
// front, YZ from the right) at one common scale with a grid and numbers in mm, a view
// in perspective, and the figures of the job (the four views the operator has in
// Trochimczuk 2008 annex E, in one picture).

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

/// The rating of a figure.
enum class Tone { kPlain, kGood, kBad };

struct Figure {
  std::string label;  ///< "error, rms"
  std::string value;  ///< "0.4 µm"
  Tone tone = Tone::kPlain;
};

/// What is written beside the views; UTF-8, any part may be empty.
struct ViewsCaption {
  std::vector<std::string> title_lines;  ///< The first one large; there is room for 2
                                         ///< more.
  std::vector<Figure> figures;           ///< In order; about 16 fit well.
  std::string verdict;                   ///< "PROVED", "1 POINT MISSED"
  Tone verdict_tone = Tone::kPlain;
};

/// Size of the picture in pixels.
inline constexpr int kViewsWidth = 1920;
inline constexpr int kViewsHeight = 1200;

/// Draws the cracks (frame glass, mm) in the block 0..block_size_mm (each side > 0).
/// Takes about a second for 400 000 points; the same input gives the same picture.
Canvas RenderViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                   const ViewsCaption& caption);

}  // namespace intaglio::render
