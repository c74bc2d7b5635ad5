#pragma once

// The picture of an engraved block. A solid or a surface is shown in perspective and in
// three parallel views (XZ from the front, YZ from the right, XY from above) at one
// common scale, with a grid and numbers in mm (the four views the operator has in
// Trochimczuk 2008 annex E). Work in one plane, such as a text, a photo or a drawing, is
// shown in one large view from where it can be read. Beside the views: the verdict, what
// has to be noted about it, the figures, and what their words mean.

#include <optional>
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

/// From where the block is seen, as the operator has it in Trochimczuk 2008 annex E.
struct Camera {
  double azimuth_rad = 0.52;   ///< to the right of the front, -pi..pi
  double elevation_rad = 0.3;  ///< above the middle, -pi/2..pi/2
  double roll_rad = 0;  ///< turns the picture about the line of sight, -pi..pi, ccw
  double zoom = 1;  ///< 1: the block; above: the part of 1 / zoom of it about the middle
  /// Glass frame; where the part would reach beyond the block it ends at its wall.
  /// Default: the middle of the work.
  std::optional<Vec3> middle_mm = {};
  /// Parallel lines stay parallel. The isometric view has an azimuth of pi/4 and an
  /// elevation of asin(1 / sqrt(3)).
  bool parallel = false;
};

struct ViewsOptions {
  std::optional<Camera> camera;  ///< one large view from there; absent: chosen views
  double grid_step_mm = 0;       ///< 0: by the scale
  bool object_frame = false;     ///< a frame around the work, with its sizes
};

/// Size of the picture in pixels.
inline constexpr int kViewsWidth = 1920;
inline constexpr int kViewsHeight = 1200;

/// Draws the cracks (frame glass, mm) in the block 0..block_size_mm (each side > 0).
/// Takes about a second for 400 000 points; the same input gives the same picture.
Canvas RenderViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                   const ViewsCaption& caption, const ViewsOptions& options = {});

}  // namespace intaglio::render
