#include <gtest/gtest.h>

#include "engrave/image/image_file.h"
#include "tests/engrave/image/pictures.h"

namespace intaglio::image {
namespace {

Rgb Ramp(int x, int y) {
  return {static_cast<std::uint8_t>(40 + 5 * x), static_cast<std::uint8_t>(60 + 4 * y),
          static_cast<std::uint8_t>(200 - 3 * x - 2 * y)};
}

// A byte of an encoder of quality 100 is off by one or two (rounding of the cosines and
// of the colours); in linear light that is up to 2 * 2.4 / 255 near white.
constexpr double kTolerance = 65535 * 0.02;

TEST(Jpeg, ColoursBecomeTheirLuminanceInLinearLight) {
  for (const bool progressive : {false, true}) {
    JpegKind kind;
    kind.progressive = progressive;
    const auto image = ParseImage(EncodeJpeg(37, 21, Ramp, kind));
    ASSERT_TRUE(image) << image.error().message;
    ASSERT_EQ(image->width, 37);
    ASSERT_EQ(image->height, 21);
    for (int y = 0; y < 21; ++y) {
      for (int x = 0; x < 37; ++x) {
        EXPECT_NEAR(image->at(x, y), 65535 * LuminanceOf(Ramp(x, y)), kTolerance);
      }
    }
  }
}

TEST(Jpeg, SaturatedColoursKeepTheirBrightness) {
  // By the luma of the file pure blue would be 0.012, six times too dark.
  const auto image = ParseImage(EncodeJpeg(16, 16, [](int, int) {
    return Rgb{0, 0, 255};
  }));
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->at(8, 8), 65535 * 0.0722, kTolerance / 4);
}

TEST(Jpeg, GreyIsRead) {
  JpegKind kind;
  kind.grey = true;
  const auto image = ParseImage(EncodeJpeg(
      16, 8,
      [](int x, int) {
        return Rgb{static_cast<std::uint8_t>(16 * x), 0, 0};
      },
      kind));
  ASSERT_TRUE(image) << image.error().message;
  for (int x = 0; x < 16; ++x) {
    EXPECT_NEAR(image->at(x, 3), 65535 * LinearOfByte(16 * x), kTolerance);
  }
}

TEST(Jpeg, IsTurnedUprightByItsOrientation) {
  constexpr int kWidth = 24, kHeight = 40;  // as seen
  const auto seen = [](int x, int y) { return 20 + 4 * x + 3 * y; };
  for (int orientation = 1; orientation <= 8; ++orientation) {
    for (const bool big_endian : {false, true}) {
      const bool turned = orientation >= 5;
      const int stored_width = turned ? kHeight : kWidth;
      const int stored_height = turned ? kWidth : kHeight;
      std::vector<int> stored(kWidth * kHeight);
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          int u = 0, v = 0;
          StoredPlace(orientation, kWidth, kHeight, x, y, u, v);
          stored[static_cast<std::size_t>(v * stored_width + u)] = seen(x, y);
        }
      }
      JpegKind kind;
      kind.orientation = orientation;
      kind.big_endian = big_endian;
      const auto image = ParseImage(EncodeJpeg(
          stored_width, stored_height,
          [&](int u, int v) {
            const auto c = static_cast<std::uint8_t>(
                stored[static_cast<std::size_t>(v * stored_width + u)]);
            return Rgb{c, c, c};
          },
          kind));
      ASSERT_TRUE(image) << image.error().message;
      ASSERT_EQ(image->width, kWidth) << orientation;
      ASSERT_EQ(image->height, kHeight) << orientation;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          ASSERT_NEAR(image->at(x, y), 65535 * LinearOfByte(seen(x, y)), kTolerance)
              << "orientation " << orientation << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST(Jpeg, EveryCutIsReportedAndEveryFlippedByteIsSurvived) {
  JpegKind kind;
  for (const bool progressive : {false, true}) {
    kind.progressive = progressive;
    kind.quality = 80;
    kind.orientation = 6;
    const std::string file = EncodeJpeg(24, 17, Ramp, kind);
    for (std::size_t size = 0; size + 2 < file.size(); ++size) {
      const auto image = ParseImage(file.substr(0, size));
      ASSERT_FALSE(image) << "cut to " << size << " of " << file.size();
      EXPECT_EQ(image.error().code, ErrorCode::kUnreadable);
    }
    for (std::size_t i = 0; i < file.size(); ++i) {
      std::string bad = file;
      bad[i] = static_cast<char>(bad[i] ^ 0x5A);
      const auto image = ParseImage(bad);
      if (image) {
        EXPECT_EQ(image->samples.size(), static_cast<std::size_t>(image->width) *
                                             static_cast<std::size_t>(image->height));
      } else {
        EXPECT_FALSE(image.error().message.empty());
      }
    }
  }
}

TEST(Jpeg, LimitsAreKept) {
  JpegKind kind;
  kind.progressive = true;
  const std::string file = EncodeJpeg(800, 600, Ramp, kind);
  ImageOptions options;
  options.limits.max_pixels = 800 * 600 - 1;
  EXPECT_EQ(ParseImage(file, options).error().code, ErrorCode::kTooLarge);
  options = {};
  options.limits.max_decoder_bytes = 1 << 20;  // its coefficients take 2.9 MB
  const auto image = ParseImage(file, options);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(image.error().message.find("progressive"), std::string::npos);
}

}  // namespace
}  // namespace intaglio::image
