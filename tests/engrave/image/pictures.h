#pragma once

// Pictures written by the libraries that others write them with, as an oracle for the
// readers, and the curve of sRGB by its definition.

#include <jpeglib.h>
#include <png.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "engrave/image/grey_image.h"

namespace intaglio::image {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
};
/// A picture whose pixels are all others.
inline Rgb Colours(int x, int y) {
  return {static_cast<std::uint8_t>(17 * x), static_cast<std::uint8_t>(23 * y),
          static_cast<std::uint8_t>(5 * x + 7 * y)};
}

/// Where EXIF 2.3 (table 6) puts pixel x, y of the picture as seen in the file.
inline void StoredPlace(int orientation, int width, int height, int x, int y, int& u,
                        int& v) {
  switch (orientation) {
    case 2:
      u = width - 1 - x, v = y;
      return;
    case 3:
      u = width - 1 - x, v = height - 1 - y;
      return;
    case 4:
      u = x, v = height - 1 - y;
      return;
    case 5:
      u = y, v = x;
      return;
    case 6:
      u = y, v = width - 1 - x;
      return;
    case 7:
      u = height - 1 - y, v = width - 1 - x;
      return;
    case 8:
      u = height - 1 - y, v = x;
      return;
    default:
      u = x, v = y;
      return;
  }
}

using Painter = std::function<Rgb(int x, int y)>;

/// Linear light of a byte of sRGB, 0..1 (IEC 61966-2-1).
inline double LinearOfByte(int byte) {
  const double v = byte / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

inline double LuminanceOf(const Rgb& c) {
  return 0.2126 * LinearOfByte(c.r) + 0.7152 * LinearOfByte(c.g) +
         0.0722 * LinearOfByte(c.b);
}

struct JpegKind {
  bool grey = false;
  bool progressive = false;
  int quality = 100;
  int orientation = 1;      // written as EXIF when not 1
  bool big_endian = false;  // of the EXIF
};

inline std::string Exif(int orientation, bool big_endian) {
  std::string exif("Exif\0\0", 6);
  const auto number = [&](unsigned value, int size) {
    for (int i = 0; i < size; ++i) {
      const int shift = 8 * (big_endian ? size - 1 - i : i);
      exif.push_back(static_cast<char>(value >> shift & 255U));
    }
  };
  exif += big_endian ? "MM" : "II";
  number(42, 2), number(8, 4), number(2, 2);                             // one directory
  number(0x010F, 2), number(2, 2), number(4, 4), number(0x61626300, 4);  // the maker
  number(0x0112, 2), number(3, 2), number(1, 4);
  number(static_cast<unsigned>(orientation), 2), number(0, 2), number(0, 4);
  return exif;
}

inline std::string EncodeJpeg(int width, int height, const Painter& paint,
                              const JpegKind& kind = {}) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = kind.grey ? 1 : 3;
  jpeg.in_color_space = kind.grey ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, kind.quality, TRUE);
  for (int i = 0; i < jpeg.num_components; ++i) {
    jpeg.comp_info[i].h_samp_factor = jpeg.comp_info[i].v_samp_factor = 1;
  }
  if (kind.progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  if (kind.orientation != 1) {
    const std::string exif = Exif(kind.orientation, kind.big_endian);
    jpeg_write_marker(&jpeg, JPEG_APP0 + 1, reinterpret_cast<const JOCTET*>(exif.data()),
                      static_cast<unsigned>(exif.size()));
  }
  std::vector<JSAMPLE> row;
  for (int y = 0; y < height; ++y) {
    row.clear();
    for (int x = 0; x < width; ++x) {
      const Rgb c = paint(x, y);
      row.push_back(c.r);
      if (!kind.grey) row.insert(row.end(), {c.g, c.b});
    }
    JSAMPROW at = row.data();
    jpeg_write_scanlines(&jpeg, &at, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::string file(reinterpret_cast<char*>(bytes), size);
  std::free(bytes);
  jpeg_destroy_compress(&jpeg);
  return file;
}

struct PngKind {
  int color_type = PNG_COLOR_TYPE_RGB;
  int depth = 8;
  bool interlaced = false;
  double gamma = 0;                // of a gAMA chunk; 0: none
  std::vector<png_color> palette;  // for PNG_COLOR_TYPE_PALETTE
  std::vector<png_byte> palette_alpha;
};

/// `rows`: the bytes of every row as the format has them.
inline std::string EncodePng(int width, int height,
                             std::vector<std::vector<png_byte>> rows,
                             const PngKind& kind) {
  std::string file;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &file,
      [](png_structp p, png_bytep bytes, std::size_t count) {
        static_cast<std::string*>(png_get_io_ptr(p))
            ->append(reinterpret_cast<char*>(bytes), count);
      },
      [](png_structp) {});
  png_set_IHDR(png, info, static_cast<png_uint_32>(width),
               static_cast<png_uint_32>(height), kind.depth, kind.color_type,
               kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (kind.gamma > 0) png_set_gAMA(png, info, kind.gamma);
  if (!kind.palette.empty()) {
    png_set_PLTE(png, info, kind.palette.data(), static_cast<int>(kind.palette.size()));
  }
  if (!kind.palette_alpha.empty()) {
    png_set_tRNS(png, info, kind.palette_alpha.data(),
                 static_cast<int>(kind.palette_alpha.size()), nullptr);
  }
  png_set_compression_level(png, 1);
  png_write_info(png, info);
  std::vector<png_bytep> pointers;
  for (auto& row : rows) pointers.push_back(row.data());
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

inline std::string EncodePng(int width, int height, const Painter& paint,
                             bool interlaced = false) {
  std::vector<std::vector<png_byte>> rows(static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb c = paint(x, y);
      auto& row = rows[static_cast<std::size_t>(y)];
      row.insert(row.end(), {c.r, c.g, c.b});
    }
  }
  PngKind kind;
  kind.interlaced = interlaced;
  return EncodePng(width, height, std::move(rows), kind);
}

/// A picture of given samples 0..1.
inline GreyImage PaintGrey(int width, int height,
                           const std::function<double(int x, int y)>& brightness) {
  GreyImage image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.samples.push_back(
          static_cast<std::uint16_t>(std::lround(65535 * brightness(x, y))));
    }
  }
  return image;
}

}  // namespace intaglio::image
