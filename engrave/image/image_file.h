#pragma once

// Pictures from files in memory: BMP (1, 4, 8, 16, 24, 32 bits, RLE4, RLE8, bit fields),
// PCX (1, 2, 4, 8, 24 bits), PNG (all kinds), JPEG (grey, colour, CMYK; baseline and
// progressive) and TIFF of one page (grey and RGB of 8 and 16 bits; of at most 8 bits
// also palettes, inks, YCbCr, CIELab), to one brightness a pixel.
//
// Points in glass scatter light, and the light that the eye gets from a patch grows with
// their number: so density has to follow linear light, not the bytes of the file.
// Brightness is the relative luminance of ITU-R BT.709 (0.2126 R + 0.7152 G + 0.0722 B,
// linear), the transfer curve that of sRGB (IEC 61966-2-1) unless a PNG gives another
// gamma. The ICC profile in a PNG, JPEG or TIFF decides instead where there is one; it
// has no effect on values as stored.

#include <cstdint>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/image/grey_image.h"

namespace intaglio::image {

/// Limits on the time and memory of reading; beyond them: ErrorCode::kTooLarge.
struct ImageLimits {
  std::uint64_t max_file_bytes = std::uint64_t{256} << 20;
  std::uint64_t max_pixels = 100'000'000;  ///< the picture itself takes 2 bytes each
  /// Memory of a decoder in addition to the picture: a progressive JPEG 2 to 6 bytes per
  /// pixel, an interlaced PNG 1 to 8, others a few rows.
  std::uint64_t max_decoder_bytes = std::uint64_t{256} << 20;
};

enum class Samples {
  kLinearLight,  ///< a photo: density of points has to follow brightness
  kAsStored,     ///< a map of depths: values as the file has them
};

struct ImageOptions {
  Samples samples = Samples::kLinearLight;
  /// What lies behind transparent pixels, 0..1 in the units of `samples`. Default white,
  /// as a viewer shows the file.
  double background = 1;
  ImageLimits limits;
};

/// The picture, turned upright by its EXIF orientation (JPEG, PNG) or its
/// own (TIFF). Errors name the place
/// and the remedy: kUnreadable (none of the five formats, damaged or cut off, a profile
/// that is damaged), kUnsupported (a kind of theirs that is not read), kTooLarge.
Result<GreyImage> ParseImage(std::string_view bytes, const ImageOptions& options = {});

}  // namespace intaglio::image
