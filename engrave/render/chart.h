#pragma once

// A picture of curves over one axis: frame, grid at round numbers, labels, a legend.

#include <string>
#include <vector>

#include "engrave/render/canvas.h"

namespace intaglio::render {

struct Curve {
  std::string name;
  std::vector<Vec2> points;  ///< in the units of the axes, in their order
};

struct ChartOptions {
  std::string title, x_label, y_label;   ///< with their units
  int width_px = 1200, height_px = 700;  ///< 200..8000
};

/// The first curve is drawn below all others. At most six colours, then again the first.
/// Points that are no numbers are left out. Throws PreconditionError for a size outside.
Canvas DrawChart(const std::vector<Curve>& curves, const ChartOptions& options);

/// Round numbers 1, 2 or 5 times a power of ten apart that cover min..max, at most
/// `count` of them and at least two; count >= 2.
std::vector<double> RoundNumbers(double min, double max, int count);

}  // namespace intaglio::render
