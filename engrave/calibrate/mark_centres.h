#pragma once

// The centres of marks in a picture, to a fraction of a pixel: small spots, darker or
// brighter than their surroundings, whose brightness changes slowly over the picture.
// Needs linear light.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/image/grey_image.h"

namespace intaglio::calibrate {

enum class MarkTone { kEither, kDark, kBright };

struct CentreOptions {
  double diameter_px = 8;             ///< of a mark, 3..200
  MarkTone tone = MarkTone::kEither;  ///< either: that of the strongest marks
};

/// Of every spot from half to twice the diameter, pixels, of a dozen or more; (0, 0) is
/// the middle of the pixel at the top left, x to the right, y down. In rows from the top.
/// kInvalidValue: the diameter is outside its range, or the picture smaller than four of
/// them; kMissing: no spot.
Result<std::vector<Vec2>> FindMarkCentres(const image::GreyImage& picture,
                                          const CentreOptions& options);

}  // namespace intaglio::calibrate
