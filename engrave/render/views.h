#pragma once

// The picture of an engraved block. A solid or a surface is shown in perspective and in
// three parallel views (XZ from the front, YZ from the right, XY from above) at one
// common scale, with a grid and numbers in mm (the four views the operator has in
// Trochimczuk 2008 annex E). Work in one plane, such as a text, a photo or a drawing, is
// shown in one large view from where it can be read. Beside the views: the verdict, what
// has to be noted about it, the figures, and what their words mean.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

/// The rating of a figure or a sentence.
enum class Tone { kPlain, kGood, kWarning, kBad };

struct Figure {
  std::string label;  ///< "error, rms"
  std::string value;  ///< "0.4 µm"
  Tone tone = Tone::kPlain;
};

/// A sentence below the verdict: on what it rests, a reason, a warning.
struct Note {
  std::string text;
  Tone tone = Tone::kPlain;
};

/// A word of the figures, and its meaning.
struct LegendEntry {
  std::string term;     ///< "stray"
  std::string meaning;  ///< "a crack where no point is planned"
};

/// What is written beside the views; UTF-8, any part may be empty. What does not fit is
/// set smaller, or, of the notes, counted.
struct ViewsCaption {
  std::vector<std::string> title_lines;  ///< The first one large; there is room for 2
                                         ///< more.
  std::vector<Figure> figures;           ///< In order; about 16 fit well.
  std::string verdict;                   ///< "PROVED", "1 POINT MISSED"
  Tone verdict_tone = Tone::kPlain;
  std::vector<Note> notes;  ///< The gravest first.
  std::vector<LegendEntry> legend;
};

/// Size of the picture in pixels.
inline constexpr int kViewsWidth = 1920;
inline constexpr int kViewsHeight = 1200;

/// Draws the cracks (frame glass, mm) in the block 0..block_size_mm (each side > 0).
/// Takes about a second for 400 000 points; the same input gives the same picture.
Canvas RenderViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                   const ViewsCaption& caption);

}  // namespace intaglio::render
