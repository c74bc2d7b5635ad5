#include "engrave/render/png_file.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/io/atomic_file.h"

namespace intaglio::render {
namespace {

/// sRGB bytes of linear light in steps of 1/65535.
std::vector<std::uint8_t> SrgbTable() {
  std::vector<std::uint8_t> table(65536);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double linear = static_cast<double>(i) / 65535.0;
    const double s = linear <= 0.0031308 ? 12.92 * linear
                                         : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    table[i] = static_cast<std::uint8_t>(std::lround(255.0 * s));
  }
  return table;
}

/// Programs mix the bytes as they are, so that any alpha from the brightest byte on gives
/// the same picture on black; a larger one is seen better on white.
int AlphaOf(int brightest) {
  const double rest = 1.0 - brightest / 255.0;
  return std::max(brightest,
                  static_cast<int>(std::lround(255.0 * (1.0 - rest * rest * rest))));
}

}  // namespace

std::vector<std::uint8_t> EncodePng(const Canvas& canvas, Opacity opacity) {
  static const std::vector<std::uint8_t> kTable = SrgbTable();
  const auto byte_of = [](float linear) {
    return kTable[static_cast<std::size_t>(
        std::lround(65535.0F * std::clamp(linear, 0.0F, 1.0F)))];
  };
  const bool has_alpha = opacity == Opacity::kOfLight;
  std::vector<std::uint8_t> pixels;
  pixels.reserve((has_alpha ? 4 : 3) * static_cast<std::size_t>(canvas.width()) *
                 static_cast<std::size_t>(canvas.height()));
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      const Color& color = canvas.at(x, y);
      const std::array<std::uint8_t, 3> rgb = {byte_of(color.r), byte_of(color.g),
                                               byte_of(color.b)};
      if (!has_alpha) {
        pixels.insert(pixels.end(), rgb.begin(), rgb.end());
        continue;
      }
      const int alpha = AlphaOf(*std::max_element(rgb.begin(), rgb.end()));
      for (const int part : rgb) {
        pixels.push_back(
            static_cast<std::uint8_t>(alpha == 0 ? 0 : (255 * part + alpha / 2) / alpha));
      }
      pixels.push_back(static_cast<std::uint8_t>(alpha));
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(canvas.width());
  image.height = static_cast<png_uint_32>(canvas.height());
  image.format = has_alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::uint8_t> file(size);
  const int written =
      png_image_write_to_memory(&image, file.data(), &size, 0, pixels.data(), 0, nullptr);
  Require(written != 0, "libpng could not write {} x {} pixels: {}", canvas.width(),
          canvas.height(), std::string_view(image.message));
  file.resize(size);
  return file;
}

Status WritePng(const std::filesystem::path& path, const Canvas& canvas,
                Opacity opacity) {
  const std::vector<std::uint8_t> file = EncodePng(canvas, opacity);
  return io::WriteFileAtomically(path, std::as_bytes(std::span(file)));
}

}  // namespace intaglio::render
