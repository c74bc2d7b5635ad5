#include <gtest/gtest.h>

#include "engrave/image/image_file.h"
#include "tests/engrave/image/pictures.h"

// The files are put together here by the letter of the format.
namespace intaglio::image {
namespace {

void Put(std::string& to, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) to.push_back(static_cast<char>(value >> 8 * i & 255U));
}

struct BmpKind {
  int width = 0, height = 0, depth = 24;
  std::uint32_t compression = 0;
  std::string palette;  ///< or masks
  std::string pixels;
};

std::string MakeBmp(const BmpKind& kind) {
  std::string file = "BM";
  Put(file, 0, 8);
  Put(file, static_cast<std::uint32_t>(54 + kind.palette.size()), 4);
  Put(file, 40, 4);
  Put(file, static_cast<std::uint32_t>(kind.width), 4);
  Put(file, static_cast<std::uint32_t>(kind.height), 4);
  Put(file, 1, 2);
  Put(file, static_cast<std::uint32_t>(kind.depth), 2);
  Put(file, kind.compression, 4);
  for (int i = 0; i < 3; ++i) Put(file, 0, 4);
  Put(file, kind.depth <= 8 ? static_cast<std::uint32_t>(kind.palette.size() / 4) : 0, 4);
  Put(file, 0, 4);
  return file + kind.palette + kind.pixels;
}

/// Greys of the given bytes.
std::string Palette(const std::vector<int>& greys) {
  std::string palette;
  for (const int grey : greys) {
    Put(palette, static_cast<std::uint32_t>(grey) * 0x010101U, 4);
  }
  return palette;
}

void ExpectGreys(const Result<GreyImage>& image,
                 const std::vector<std::vector<int>>& rows) {
  ASSERT_TRUE(image) << image.error().message;
  ASSERT_EQ(image->height, static_cast<int>(rows.size()));
  ASSERT_EQ(image->width, static_cast<int>(rows[0].size()));
  for (int y = 0; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) {
      const int grey = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
      EXPECT_NEAR(image->at(x, y), 65535 * LinearOfByte(grey), 0.6) << x << ", " << y;
    }
  }
}

TEST(Bmp, OneBitAPixelFromTheBottomUp) {
  BmpKind kind{10, 2, 1, 0, Palette({0, 255}), {}};
  kind.pixels = std::string("\xB1\x40\0\0\x00\xC0\0\0", 8);
  ExpectGreys(ParseImage(MakeBmp(kind)), {{0, 0, 0, 0, 0, 0, 0, 0, 255, 255},
                                          {255, 0, 255, 255, 0, 0, 0, 255, 0, 255}});
}

TEST(Bmp, FourAndEightBitsWithAPalette) {
  BmpKind kind{3, 1, 4, 0, Palette({10, 20, 30, 40}), std::string("\x31\x20\0\0", 4)};
  ExpectGreys(ParseImage(MakeBmp(kind)), {{40, 20, 30}});
  kind.depth = 8;
  kind.pixels = std::string("\x02\x00\x03\0", 4);
  ExpectGreys(ParseImage(MakeBmp(kind)), {{30, 10, 40}});
  kind.pixels = std::string("\x02\x09\x03\0", 4);
  ExpectGreys(ParseImage(MakeBmp(kind)), {{30, 0, 40}});  // past the palette: black
}

TEST(Bmp, TrueColourAndFromTheTopDown) {
  BmpKind kind{1, -2, 24, 0, {}, std::string("\x01\x02\x80\0\xFF\xFF\xFF\0", 8)};
  const auto image = ParseImage(MakeBmp(kind));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_NEAR(image->at(0, 0), 65535 * LuminanceOf({0x80, 2, 1}), 0.6);
  EXPECT_EQ(image->at(0, 1), 65535);
}

TEST(Bmp, MasksOfSixteenAndThirtyTwoBits) {
  std::string masks;
  Put(masks, 0xF800, 4), Put(masks, 0x07E0, 4), Put(masks, 0x001F, 4);
  BmpKind kind{1, 1, 16, 3, masks, {}};
  Put(kind.pixels, 0xF800, 4);
  auto image = ParseImage(MakeBmp(kind));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_NEAR(image->at(0, 0), 65535 * 0.2126, 1);
  kind = {1, 1, 32, 0, {}, {}};
  Put(kind.pixels, 0x00FFFFFF, 4);  // the fourth byte is nothing
  image = ParseImage(MakeBmp(kind));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->at(0, 0), 65535);
}

TEST(Bmp, RunsOfEightAndFourBits) {
  BmpKind kind{5, 3, 8, 1, Palette({0, 100, 200}), {}};
  // Below: 3 of 1, 2 of 2. Then a step right by 1 and up by 1; two as they are; end.
  kind.pixels =
      std::string("\x03\x01\x02\x02\0\0\0\x02\x01\x01\0\x03\x02\x01\x02\0\0\x01", 18);
  ExpectGreys(ParseImage(MakeBmp(kind)),
              {{0, 200, 100, 200, 0}, {0, 0, 0, 0, 0}, {100, 100, 100, 200, 200}});
  kind.depth = 4;
  kind.compression = 2;
  kind.height = 1;
  kind.pixels = std::string("\x05\x12\0\x01", 4);
  ExpectGreys(ParseImage(MakeBmp(kind)), {{100, 200, 100, 200, 100}});
}

TEST(Bmp, TheOldHeaderIsRead) {
  std::string file = "BM";
  Put(file, 0, 8), Put(file, 26 + 6, 4), Put(file, 12, 4);
  Put(file, 2, 2), Put(file, 1, 2), Put(file, 1, 2), Put(file, 1, 2);
  file += std::string("\0\0\0\xFF\xFF\xFF", 6) + std::string("\x40\0\0\0", 4);
  ExpectGreys(ParseImage(file), {{0, 255}});
}

TEST(Bmp, EveryCutIsReportedAndEveryFlippedByteIsSurvived) {
  const BmpKind plain{5, 3, 24, 0, {}, std::string(48, 'x')};
  BmpKind runs{5, 2, 8, 1, Palette({0, 100, 200}), {}};
  runs.pixels = std::string("\x05\x01\0\0\0\x05\1\2\1\2\1\0\0\x01", 14);
  ImageOptions options;
  options.limits.max_pixels = 1'000'000;
  for (const BmpKind& kind : {plain, runs}) {
    const std::string file = MakeBmp(kind);
    for (std::size_t size = 2; size < file.size(); ++size) {
      const auto image = ParseImage(file.substr(0, size), options);
      ASSERT_FALSE(image) << size;
      EXPECT_EQ(image.error().code, ErrorCode::kUnreadable);
    }
    for (std::size_t i = 2; i < file.size(); ++i) {
      std::string bad = file;
      bad[i] = static_cast<char>(bad[i] ^ 0x83);
      const auto image = ParseImage(bad, options);
      if (!image) {
        EXPECT_FALSE(image.error().message.empty());
      }
    }
  }
}

TEST(Bmp, HugeSizesAreRefusedAtOnce) {
  for (const int width : {2'000'000'000, -5, 0}) {
    const auto image = ParseImage(MakeBmp({width, 2'000'000'000, 24, 0, {}, "x"}));
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code,
              width > 0 ? ErrorCode::kTooLarge : ErrorCode::kUnreadable);
  }
  // The most negative number has no positive counterpart.
  EXPECT_FALSE(ParseImage(MakeBmp({1, INT32_MIN, 24, 0, {}, "x"})));
}

}  // namespace
}  // namespace intaglio::image
