#include "engrave/discretize/picture/halftone_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/discretize/spacing/statistics.h"

namespace intaglio::discretize {
namespace {

int CellCount(double length_mm, double step_mm) {
  return std::max(1, static_cast<int>(std::lround(length_mm / step_mm)));
}

}  // namespace

HalftoneGrid::HalftoneGrid(double width, double height, double distance_mm,
                           bool is_triangular)
    : width_mm(width), height_mm(height), triangular(is_triangular) {
  step_x_mm = distance_mm * kRoundingAllowance;
  step_y_mm = step_x_mm * (triangular ? std::numbers::sqrt3 / 2 : 1);
  columns = CellCount(width, step_x_mm) + 2;
  rows = CellCount(height, step_y_mm) + 2;
}

/// Layer i is shifted by the fractions (i p / n, i q / n) of the grid's two steps: a
/// lattice of n places within a cell.
Vec2 HalftoneGrid::ShiftOf(int layer, int layer_count, int p, int q) const {
  const double u = static_cast<double>(layer * p % layer_count) / layer_count;
  const double v = static_cast<double>(layer * q % layer_count) / layer_count;
  const double x = u + (triangular ? v / 2 : 0);
  return {(x - std::floor(x)) * step_x_mm, v * step_y_mm};
}

double HalftoneGrid::StaggerOf(int layer_count, int p, int q) const {
  double smallest = width_mm + height_mm;
  for (int layer = 1; layer < layer_count; ++layer) {
    const Vec2 shift = ShiftOf(layer, layer_count, p, q);
    for (int row = -2; row <= 2; ++row) {
      for (int column = -2; column <= 2; ++column) {
        const double x = column + (triangular && row % 2 != 0 ? 0.5 : 0);
        const Vec2 place(x * step_x_mm, row * step_y_mm);
        smallest = std::min(smallest, (shift - place).norm());
      }
    }
  }
  return smallest;
}

double HalftoneGrid::LayerStagger(int layer_count) const {
  double best = 0;
  for (int p = 0; p < layer_count; ++p) {
    for (int q = 0; q < layer_count; ++q) {
      best = std::max(best, StaggerOf(layer_count, p, q));
    }
  }
  return best;
}

void HalftoneGrid::PlaceLayer(int layer, int layer_count,
                              const image::FloatImage& picture) {
  const double best = LayerStagger(layer_count);
  int p = 0, q = 0;
  while (layer_count > 1 && StaggerOf(layer_count, p, q) < best) {
    q = (q + 1) % layer_count;
    if (q == 0) ++p;
  }
  shift_mm = ShiftOf(layer, layer_count, p, q);
  // Cells of the two kinds of rows begin half a cell apart: so means are taken over half
  // cells, two of which make a cell.
  const int parts = triangular ? 2 : 1;
  const int extra = triangular ? 1 : 0;
  const double left_mm = At(0, 1).x() - step_x_mm / 2;
  const double right_mm = left_mm + (columns + 0.5 * extra) * step_x_mm;
  const double low_mm = At(0, 0).y() - step_y_mm / 2;
  const double high_mm = low_mm + rows * step_y_mm;
  const image::FloatImage means =
      image::Resample(picture, parts * columns + extra, rows, image::Filter::kArea,
                      {left_mm / width_mm, 1 - high_mm / height_mm, right_mm / width_mm,
                       1 - low_mm / height_mm});
  brightness.clear();
  brightness.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int row = 0; row < rows; ++row) {
    const int y = rows - 1 - row;
    const int begin = row % 2 == 0 ? extra : 0;
    for (int column = 0; column < columns; ++column) {
      const int x = parts * column + begin;
      brightness.push_back(triangular ? (means.at(x, y) + means.at(x + 1, y)) / 2
                                      : means.at(x, y));
    }
  }
}

}  // namespace intaglio::discretize
