#pragma once

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/galvo/mark_ticks.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// A drawing, and how fast its contours are marked.
struct DrawingOptions {
  std::string file;
  double mark_mm_s = 1000, jump_mm_s = 5000;
  double size_limits = 1;
};

/// FILE and the speeds, first of a command's options.
void AddDrawingOptions(command_line::Command command, DrawingOptions& options);

/// The contours of a drawing (.dxf, .svg, .hpgl, .plt, .nci) as strokes, its middle at
/// the origin, mm; open curves that meet are joined. Prints the warnings of the reader.
Result<std::vector<galvo::MarkStroke>> ReadMarkStrokes(const DrawingOptions& options);

/// Lowest and highest coordinates of a stroke.
Box3 ExtentOfStroke(const galvo::MarkStroke& stroke);

double LengthOfStroke(const galvo::MarkStroke& stroke);

/// Its places, of a closed one with the first again.
std::vector<Vec2> OutlineOf(const galvo::MarkStroke& stroke);

}  // namespace intaglio::cli
