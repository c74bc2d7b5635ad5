#pragma once

#include <string_view>

#include "engrave/image/grey_image.h"

namespace intaglio::image {

/// The orientation 1..8 (EXIF 2.3, tag 0x0112) in the body of an APP1 segment that begins
/// with "Exif\0\0"; 1 (upright) when there is none, or no valid one: a photo is not
/// refused because of its metadata.
int OrientationOf(std::string_view app1);

/// The picture turned so that it is seen upright. 2 to 4 turn it in place.
GreyImage Upright(GreyImage image, int orientation);

}  // namespace intaglio::image
