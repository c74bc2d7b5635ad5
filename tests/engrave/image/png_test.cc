#include <gtest/gtest.h>

#include "engrave/image/image_file.h"
#include "engrave/io/whole_file.h"
#include "tests/engrave/image/pictures.h"

namespace intaglio::image {
namespace {

TEST(Png, ColoursBecomeTheirLuminanceInLinearLight) {
  for (const bool interlaced : {false, true}) {
    const auto image = ParseImage(EncodePng(16, 11, Colours, interlaced));
    ASSERT_TRUE(image) << image.error().message;
    ASSERT_EQ(image->width, 16);
    ASSERT_EQ(image->height, 11);
    for (int y = 0; y < 11; ++y) {
      for (int x = 0; x < 16; ++x) {
        // Half a step of 16 bits, and the rounding of three tables.
        EXPECT_NEAR(image->at(x, y), 65535 * LuminanceOf(Colours(x, y)), 0.6);
      }
    }
  }
}

// 60 x 30 pixels, the dark strip on the left; the orientation 6 of eXIf (EXIF 2.3, 4.6.4)
// turns it a quarter to the right: the strip is at the top. Made for the tests.
TEST(Png, IsTurnedUprightByItsExif) {
  const auto bytes = io::ReadWholeFile(INTAGLIO_SOURCE_DIR "/tests/data/kinds/turned.png",
                                       std::uint64_t{1} << 20);
  ASSERT_TRUE(bytes);
  const auto image = ParseImage(*bytes);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->width, 30);
  EXPECT_EQ(image->height, 60);
  EXPECT_LT(image->at(15, 2), image->at(15, 57));
}

TEST(Png, BlackAndWhiteAreExact) {
  const auto image = ParseImage(EncodePng(2, 1, [](int x, int) {
    const auto v = static_cast<std::uint8_t>(255 * x);
    return Rgb{v, v, v};
  }));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->at(0, 0), 0);
  EXPECT_EQ(image->at(1, 0), 65535);
}

TEST(Png, DepthsOfSixteenBitsComeAsStored) {
  PngKind kind;
  kind.color_type = PNG_COLOR_TYPE_GRAY;
  kind.depth = 16;
  ImageOptions options;
  options.samples = Samples::kAsStored;
  const auto image =
      ParseImage(EncodePng(3, 1, {{0x00, 0x01, 0x12, 0x34, 0xFF, 0xFE}}, kind), options);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->samples, (std::vector<std::uint16_t>{0x0001, 0x1234, 0xFFFE}));
}

TEST(Png, BitsAndPalettesAreExpanded) {
  PngKind kind;
  kind.color_type = PNG_COLOR_TYPE_GRAY;
  kind.depth = 1;
  const auto bits = ParseImage(EncodePng(10, 1, {{0b10110001, 0b01000000}}, kind));
  ASSERT_TRUE(bits) << bits.error().message;
  const int expected[] = {1, 0, 1, 1, 0, 0, 0, 1, 0, 1};
  for (int x = 0; x < 10; ++x) EXPECT_EQ(bits->at(x, 0), 65535 * expected[x]);

  kind.color_type = PNG_COLOR_TYPE_PALETTE;
  kind.depth = 2;
  kind.palette = {{0, 0, 0}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  kind.palette_alpha = {255, 255, 255, 0};
  const auto palette = ParseImage(EncodePng(4, 1, {{0b00011011}}, kind));
  ASSERT_TRUE(palette) << palette.error().message;
  EXPECT_EQ(palette->at(0, 0), 0);
  EXPECT_NEAR(palette->at(1, 0), 65535 * 0.2126, 1);
  EXPECT_NEAR(palette->at(2, 0), 65535 * 0.7152, 1);
  EXPECT_EQ(palette->at(3, 0), 65535) << "transparent blue over white";
}

TEST(Png, TransparencyIsComposedInLinearLight) {
  PngKind kind;
  kind.color_type = PNG_COLOR_TYPE_RGB_ALPHA;
  const std::vector<std::vector<png_byte>> rows = {{100, 100, 100, 51}};
  for (const double background : {1.0, 0.0, 0.25}) {
    ImageOptions options;
    options.background = background;
    const auto image = ParseImage(EncodePng(1, 1, rows, kind), options);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_NEAR(image->at(0, 0), 65535 * (0.2 * LinearOfByte(100) + 0.8 * background), 2);
  }
}

TEST(Png, AGammaOfItsOwnIsTakenOff) {
  PngKind kind;
  kind.color_type = PNG_COLOR_TYPE_GRAY;
  kind.gamma = 1;
  const auto linear = ParseImage(EncodePng(1, 1, {{128}}, kind));
  ASSERT_TRUE(linear);
  EXPECT_NEAR(linear->at(0, 0), 65535 * 128 / 255.0, 1);
  kind.gamma = 0.45455;
  const auto usual = ParseImage(EncodePng(1, 1, {{128}}, kind));
  ASSERT_TRUE(usual);
  EXPECT_NEAR(usual->at(0, 0), 65535 * LinearOfByte(128), 1) << "the curve of sRGB";
}

TEST(Png, EveryCutIsReportedAndEveryFlippedByteIsSurvived) {
  const std::string file = EncodePng(16, 11, Colours);
  for (std::size_t size = 0; size < file.size(); ++size) {
    const auto image = ParseImage(file.substr(0, size));
    ASSERT_FALSE(image) << "cut to " << size;
    EXPECT_EQ(image.error().code, ErrorCode::kUnreadable);
    EXPECT_FALSE(image.error().message.empty());
  }
  for (std::size_t i = 0; i < file.size(); ++i) {
    std::string bad = file;
    bad[i] = static_cast<char>(bad[i] ^ 0x5A);
    const auto image = ParseImage(bad);
    if (image) {
      EXPECT_EQ(image->samples.size(), 16U * 11U);
    }
  }
}

TEST(Png, LimitsAreKept) {
  ImageOptions options;
  options.limits.max_pixels = 175;
  const auto pixels = ParseImage(EncodePng(16, 11, Colours), options);
  ASSERT_FALSE(pixels);
  EXPECT_EQ(pixels.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(pixels.error().value, "16 x 11");
  options = {};
  options.limits.max_file_bytes = 60;
  EXPECT_EQ(ParseImage(EncodePng(16, 11, Colours), options).error().code,
            ErrorCode::kTooLarge);
  options = {};
  options.limits.max_decoder_bytes = 3 * 16 * 11 - 1;
  EXPECT_TRUE(ParseImage(EncodePng(16, 11, Colours), options));
  EXPECT_EQ(ParseImage(EncodePng(16, 11, Colours, true), options).error().code,
            ErrorCode::kTooLarge);
}

TEST(ImageFile, OtherFilesAreRefusedBySentence) {
  for (const std::string text : {"", "GIF89a", "B", "\x89PNG"}) {
    const auto image = ParseImage(text);
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::kUnreadable);
    EXPECT_NE(image.error().message.find("PNG"), std::string::npos);
  }
}

}  // namespace
}  // namespace intaglio::image
