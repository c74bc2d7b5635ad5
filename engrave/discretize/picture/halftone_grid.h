#pragma once

// The places that the points of a layer can take, and the brightness of each.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/image/resample.h"

namespace intaglio::discretize {

/// A square or triangular grid in the middle of the panel [0, width] x [0, height], mm, y
/// up; places the distance apart. A border of one place surrounds it, so that a shifted
/// grid covers the panel too: call Contains before using a place.
struct HalftoneGrid {
  double width_mm = 0, height_mm = 0;
  double step_x_mm = 0, step_y_mm = 0;
  bool triangular = false;  ///< even rows a quarter of a step right, odd ones left
  int columns = 0, rows = 0;
  Vec2 shift_mm = Vec2::Zero();
  std::vector<float> brightness;  ///< of each place, row 0 lowest; the mean of its cell

  HalftoneGrid(double width, double height, double distance_mm, bool is_triangular);

  Vec2 At(int column, int row) const {
    const double aside = triangular ? (row % 2 == 0 ? 0.25 : -0.25) : 0;
    return {
        width_mm / 2 + (column - 0.5 * (columns - 1) + aside) * step_x_mm + shift_mm.x(),
        height_mm / 2 + (row - 0.5 * (rows - 1)) * step_y_mm + shift_mm.y()};
  }
  bool Contains(const Vec2& p_mm) const {
    return p_mm.x() >= 0 && p_mm.x() < width_mm && p_mm.y() >= 0 && p_mm.y() < height_mm;
  }
  float BrightnessAt(int column, int row) const {
    return brightness[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                      static_cast<std::size_t>(column)];
  }

  /// Moves the grid so that layers 0 .. layer_count - 1, seen from above, are as far from
  /// each other as possible, and samples the brightness there.
  void PlaceLayer(int layer, int layer_count, const image::FloatImage& picture);

  /// The minimum distance, seen from above, of places of different layers, mm.
  double LayerStagger(int layer_count) const;

 private:
  Vec2 ShiftOf(int layer, int layer_count, int p, int q) const;
  double StaggerOf(int layer_count, int p, int q) const;
};

}  // namespace intaglio::discretize
