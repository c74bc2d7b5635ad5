#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include <cstring>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "engrave/image/image_file.h"
#include "tests/engrave/image/pictures.h"
#include "tests/test_folder.h"

namespace intaglio::image {
namespace {

using ::testing::HasSubstr;

struct TiffKind {
  std::uint16_t bits = 8, channels = 3, photometric = PHOTOMETRIC_RGB;
  std::uint16_t compression = COMPRESSION_NONE, orientation = ORIENTATION_TOPLEFT;
  std::uint16_t alpha = 0;  // EXTRASAMPLE_...; 0: none
  bool tiled = false, float_samples = false;
  const char* mode = "w";
  std::vector<std::uint16_t> palette = {};  // of grey steps
};

using Rows = std::vector<std::vector<std::uint8_t>>;

void WritePage(TIFF* tiff, std::uint32_t width, const Rows& rows, const TiffKind& kind) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(rows.size()));
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.channels);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.photometric);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, kind.orientation);
  if (kind.alpha != 0) TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &kind.alpha);
  if (kind.float_samples) TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  if (!kind.palette.empty()) {
    const std::uint16_t* map = kind.palette.data();
    TIFFSetField(tiff, TIFFTAG_COLORMAP, map, map, map);
  }
  if (kind.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16u),
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16u);
    std::vector<std::uint8_t> tile(std::size_t{16} * 16 * kind.channels * kind.bits / 8);
    for (std::size_t y = 0; y < rows.size(); ++y)
      std::copy(rows[y].begin(), rows[y].end(), tile.begin() + y * tile.size() / 16);
    TIFFWriteTile(tiff, tile.data(), 0, 0, 0, 0);
    return;
  }
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4u);
  for (std::uint32_t y = 0; y < rows.size(); ++y) {
    std::vector<std::uint8_t> row = rows[y];
    TIFFWriteScanline(tiff, row.data(), y, 0);
  }
}

class Tiff : public ::testing::Test {
 protected:
  /// The bytes that libtiff writes: of a page for each entry of `pages`.
  std::string Encode(std::uint32_t width, const std::vector<Rows>& pages,
                     const TiffKind& kind) {
    const std::string file = folder_ / "picture.tif";
    TIFF* tiff = TIFFOpen(file.c_str(), kind.mode);
    for (const Rows& rows : pages) {
      WritePage(tiff, width, rows, kind);
      if (pages.size() > 1) TIFFWriteDirectory(tiff);
    }
    TIFFClose(tiff);
    std::ostringstream bytes;
    bytes << std::ifstream(file, std::ios::binary).rdbuf();
    return bytes.str();
  }
  std::string Encode(std::uint32_t width, const Rows& rows, const TiffKind& kind) {
    return Encode(width, std::vector<Rows>{rows}, kind);
  }

  const std::filesystem::path folder_ = test::FreshFolder();
};

Rows ColourRows(int width, int height, int alpha = -1) {
  Rows rows(static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb c = Colours(x, y);
      rows[static_cast<std::size_t>(y)].insert(rows[static_cast<std::size_t>(y)].end(),
                                               {c.r, c.g, c.b});
      if (alpha >= 0)
        rows[static_cast<std::size_t>(y)].push_back(static_cast<std::uint8_t>(alpha));
    }
  }
  return rows;
}

/// Bytes of samples of 16 bits, of this computer's byte order.
Rows WideRows(const std::vector<std::vector<std::uint16_t>>& rows) {
  Rows bytes;
  for (const auto& row : rows) {
    bytes.emplace_back(2 * row.size());
    std::memcpy(bytes.back().data(), row.data(), bytes.back().size());
  }
  return bytes;
}

TEST_F(Tiff, ColoursBecomeTheirLuminanceHoweverTheyAreStored) {
  std::vector<TiffKind> kinds(5);
  kinds[1].compression = COMPRESSION_LZW;
  kinds[2].compression = COMPRESSION_ADOBE_DEFLATE;
  kinds[3].mode = "wb";  // the other byte order
  kinds[4].mode = "w8";  // BigTIFF
  kinds.push_back({.tiled = true});
  for (const TiffKind& kind : kinds) {
    const int width = 16;
    const auto image =
        ParseImage(Encode(16, ColourRows(width, kind.tiled ? 16 : 11), kind));
    ASSERT_TRUE(image) << image.error().message;
    ASSERT_EQ(image->width, width);
    ASSERT_EQ(image->height, kind.tiled ? 16 : 11);
    for (int y = 0; y < 11; ++y) {
      for (int x = 0; x < width; ++x) {
        EXPECT_NEAR(image->at(x, y), 65535 * LuminanceOf(Colours(x, y)), 0.6);
      }
    }
  }
}

TEST_F(Tiff, AMapOfDepthsKeepsItsSixteenBits) {
  ImageOptions options;
  options.samples = Samples::kAsStored;
  TiffKind kind{.bits = 16, .channels = 1, .photometric = PHOTOMETRIC_MINISBLACK};
  for (const char* mode : {"wl", "wb"}) {
    kind.mode = mode;
    const auto image =
        ParseImage(Encode(3, WideRows({{1, 0x1234, 0xFFFE}}), kind), options);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->samples, (std::vector<std::uint16_t>{1, 0x1234, 0xFFFE}));
  }
  kind.photometric = PHOTOMETRIC_MINISWHITE;
  const auto inverse =
      ParseImage(Encode(3, WideRows({{1, 0x1234, 0xFFFE}}), kind), options);
  ASSERT_TRUE(inverse) << inverse.error().message;
  EXPECT_EQ(inverse->samples, (std::vector<std::uint16_t>{0xFFFE, 0xEDCB, 1}));
}

// A scan of black and white, 1 bit a pixel, and a picture of a palette.
TEST_F(Tiff, BilevelAndPalettesAreRead) {
  const Rows rows = {{0b10100000}, {0b01000000}};
  for (const bool white_first : {false, true}) {
    TiffKind kind{.bits = 1, .channels = 1, .compression = COMPRESSION_CCITTFAX4};
    kind.photometric = white_first ? PHOTOMETRIC_MINISWHITE : PHOTOMETRIC_MINISBLACK;
    const auto image = ParseImage(Encode(3, rows, kind));
    ASSERT_TRUE(image) << image.error().message;
    const std::uint16_t one = white_first ? 0 : 65535, zero = white_first ? 65535 : 0;
    EXPECT_EQ(image->samples,
              (std::vector<std::uint16_t>{one, zero, one, zero, one, zero}));
  }
  TiffKind palette{.bits = 8, .channels = 1, .photometric = PHOTOMETRIC_PALETTE};
  palette.palette.resize(256);
  palette.palette[7] = 65535, palette.palette[9] = 0x8080;
  const auto image = ParseImage(Encode(2, {{7, 9}}, palette));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->samples[0], 65535);
  EXPECT_NEAR(image->samples[1], 65535 * LinearOfByte(0x80), 0.6);
}

TEST_F(Tiff, WhatIsTransparentShowsTheBackground) {
  ImageOptions options;
  options.background = 1;
  TiffKind kind{.channels = 4, .alpha = EXTRASAMPLE_UNASSALPHA};
  auto image = ParseImage(Encode(4, ColourRows(4, 3, 0), kind), options);
  ASSERT_TRUE(image) << image.error().message;
  for (const std::uint16_t sample : image->samples) EXPECT_EQ(sample, 65535);
  image = ParseImage(Encode(4, ColourRows(4, 3, 255), kind), options);
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->at(3, 2), 65535 * LuminanceOf(Colours(3, 2)), 0.6);
  // Stored multiplied by its alpha: 64 of 128 is a grey of 127.
  kind.alpha = EXTRASAMPLE_ASSOCALPHA;
  options.background = 0;
  image = ParseImage(Encode(1, {{64, 64, 64, 128}}, kind), options);
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->samples[0], 65535 * LinearOfByte(127) * 128 / 255, 2);
}

// The eight orientations are those of EXIF (TIFF 6.0, Orientation).
TEST_F(Tiff, IsTurnedUpright) {
  for (std::uint16_t orientation = 1; orientation <= 8; ++orientation) {
    for (const bool tiled : {false, true}) {
      TiffKind kind{.orientation = orientation, .tiled = tiled};
      const auto turned = ParseImage(Encode(16, ColourRows(16, 16), kind));
      ASSERT_TRUE(turned) << turned.error().message;
      int u = 0, v = 0;
      StoredPlace(orientation, 16, 16, 3, 1, u, v);
      EXPECT_NEAR(turned->at(3, 1), 65535 * LuminanceOf(Colours(u, v)), 0.6)
          << orientation << ", " << tiled;
    }
  }
}

TEST_F(Tiff, WhatWouldBeLeftOutOrRoundedIsRefused) {
  const Rows rows = ColourRows(2, 2);
  const auto pages = ParseImage(Encode(2, std::vector<Rows>{rows, rows}, {}));
  ASSERT_FALSE(pages);
  EXPECT_EQ(pages.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(pages.error().message,
              HasSubstr("2 pages, which is not read: save the one"));

  TiffKind fractions{.bits = 32, .channels = 1, .photometric = PHOTOMETRIC_MINISBLACK};
  fractions.float_samples = true;
  const auto floats = ParseImage(Encode(1, {{0, 0, 0, 0}}, fractions));
  ASSERT_FALSE(floats);
  EXPECT_THAT(floats.error().message, HasSubstr("signed or fractions"));

  TiffKind wide{.bits = 16, .channels = 1, .photometric = PHOTOMETRIC_MINISBLACK};
  wide.tiled = true;
  const auto tiles =
      ParseImage(Encode(16, Rows(16, std::vector<std::uint8_t>(32)), wide));
  ASSERT_FALSE(tiles);
  EXPECT_THAT(tiles.error().message, HasSubstr("in strips"));
}

TEST_F(Tiff, IsBoundedByItsLimits) {
  ImageOptions options;
  options.limits.max_pixels = 3;
  const auto image = ParseImage(Encode(2, ColourRows(2, 2), {}), options);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, ErrorCode::kTooLarge);
}

// A cut file is refused, and a damaged one is a picture of its size or a sentence.
TEST_F(Tiff, DamagedFilesEndInASentence) {
  std::mt19937_64 random(3);
  for (const std::uint16_t compression :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE}) {
    for (const bool tiled : {false, true}) {
      TiffKind kind{.compression = compression, .tiled = tiled};
      const std::string whole = Encode(16, ColourRows(16, 16), kind);
      ASSERT_TRUE(ParseImage(whole));
      EXPECT_FALSE(ParseImage(std::string_view(whole).substr(0, whole.size() / 2)));
      for (int i = 0; i < 300; ++i) {
        std::string damaged = whole;
        for (int k = 0; k < 3; ++k)
          damaged[random() % damaged.size()] = static_cast<char>(random());
        ImageOptions options;
        options.limits.max_pixels = 100'000;
        options.limits.max_decoder_bytes = 1 << 20;
        const auto image = ParseImage(damaged, options);
        if (!image) {
          EXPECT_FALSE(image.error().message.empty());
          continue;
        }
        EXPECT_EQ(image->samples.size(), static_cast<std::size_t>(image->width) *
                                             static_cast<std::size_t>(image->height));
      }
    }
  }
}

}  // namespace
}  // namespace intaglio::image
