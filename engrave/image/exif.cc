#include "engrave/image/exif.h"

#include <algorithm>
#include <cstdint>

// The body is a TIFF file: "II" or "MM" (byte order), 42, the place of the first
// directory; a directory is a count and entries of 12 bytes: tag, type, count, value.

namespace intaglio::image {
namespace {

constexpr std::string_view kSignature("Exif\0\0", 6);

/// An unsigned number of 2 or 4 bytes; false past the end.
bool Number(std::string_view tiff, std::size_t at, std::size_t size, bool little,
            std::uint32_t& value) {
  if (at > tiff.size() || tiff.size() - at < size) return false;
  value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t place = little ? size - 1 - i : i;
    value = value << 8 | static_cast<std::uint8_t>(tiff[at + place]);
  }
  return true;
}

/// Columns become rows: the picture mirrored about the diagonal from the upper left.
GreyImage Transposed(const GreyImage& image) {
  GreyImage result{image.height, image.width, {}};
  result.samples.resize(image.samples.size());
  constexpr int kTile = 32;  // both pictures stay within the cache
  for (int y0 = 0; y0 < image.height; y0 += kTile) {
    for (int x0 = 0; x0 < image.width; x0 += kTile) {
      for (int y = y0; y < std::min(y0 + kTile, image.height); ++y) {
        for (int x = x0; x < std::min(x0 + kTile, image.width); ++x) {
          result.samples[static_cast<std::size_t>(x) *
                             static_cast<std::size_t>(image.height) +
                         static_cast<std::size_t>(y)] = image.at(x, y);
        }
      }
    }
  }
  return result;
}

void MirrorRows(GreyImage& image) {
  for (auto row = image.samples.begin(); row != image.samples.end(); row += image.width) {
    std::reverse(row, row + image.width);
  }
}

}  // namespace

int OrientationOf(std::string_view app1) {
  if (!app1.starts_with(kSignature)) return 1;
  const std::string_view tiff = app1.substr(kSignature.size());
  const bool little = tiff.starts_with("II");
  if (!little && !tiff.starts_with("MM")) return 1;
  std::uint32_t directory = 0, entries = 0;
  if (!Number(tiff, 4, 4, little, directory)) return 1;
  if (!Number(tiff, directory, 2, little, entries)) return 1;
  for (std::uint32_t i = 0; i < entries; ++i) {
    const std::size_t entry = std::size_t{directory} + 2 + std::size_t{12} * i;
    std::uint32_t tag = 0, orientation = 0;
    if (!Number(tiff, entry, 2, little, tag)) return 1;
    if (tag != 0x0112) continue;
    if (!Number(tiff, entry + 8, 2, little, orientation)) return 1;
    return orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : 1;
  }
  return 1;
}

GreyImage Upright(GreyImage image, int orientation) {
  if (image.samples.empty()) return image;
  // 5 to 8 are 1 to 4 of the transposed picture.
  if (orientation >= 5) image = Transposed(image);
  switch (orientation >= 5 ? orientation - 4 : orientation) {
    case 2:
      MirrorRows(image);
      break;
    case 3:
      std::reverse(image.samples.begin(), image.samples.end());
      break;
    case 4:
      std::reverse(image.samples.begin(), image.samples.end());
      MirrorRows(image);
      break;
    default:
      break;
  }
  return image;
}

}  // namespace intaglio::image
