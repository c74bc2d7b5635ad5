#pragma once

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/image/resample.h"

namespace intaglio::discretize {

/// Adjustments of a photo's brightness before it becomes a density of points, applied in
/// this order, on the scale of picture editors (sRGB, 0 black .. 1 white, a medium grey
/// 0.5). The defaults change nothing: density follows linear light.
struct ToneCurve {
  bool invert = false;        ///< the negative: v -> 1 - v
  double brightness = 0;      ///< -1..1, added
  double contrast_ratio = 1;  ///< 0..10, about 0.5
  double gamma = 1;           ///< 0.1..10, v^(1 / gamma): above 1 brightens the middle
  std::vector<Vec2> points;   ///< (from, to), each 0..1, from rising; straight between

  bool IsIdentity() const {
    return !invert && brightness == 0 && contrast_ratio == 1 && gamma == 1 &&
           points.empty();
  }
};

/// kInvalidValue names the first value outside its range.
Status CheckTone(const ToneCurve& tone);

/// On the scale of editors.
double ApplyTone(const ToneCurve& tone, double shown);

/// The values, linear light, after the curve; linear light again.
void ApplyTone(const ToneCurve& tone, image::FloatImage& picture);

}  // namespace intaglio::discretize
