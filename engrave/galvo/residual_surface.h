#pragma once

// A smooth surface through scattered vectors: uniform cubic B-splines by least squares.

#include <span>

#include "engrave/galvo/field_grid.h"

namespace intaglio::galvo {

struct PlacedVector {
  Vec2 place_mm = Vec2::Zero();
  Vec2 value_mm = Vec2::Zero();
};

class ResidualSurface {
 public:
  /// `cells` a side over a field of this width around the origin, >= 1. Weights that no
  /// vector determines are the smallest that there are.
  ResidualSurface(std::span<const PlacedVector> vectors, double width_mm, int cells);

  Vec2 At(const Vec2& place_mm) const;
  /// (cells + 3)^2: how many vectors it takes for as many weights.
  static int WeightCount(int cells) { return (cells + 3) * (cells + 3); }

 private:
  double width_mm_;
  int cells_;
  Eigen::Matrix<double, Eigen::Dynamic, 2> weights_mm_;
};

}  // namespace intaglio::galvo
