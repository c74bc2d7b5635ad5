#include "engrave/render/png_file.h"

#include <gtest/gtest.h>
#include <png.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/test_folder.h"

namespace intaglio::render {
namespace {

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

Picture Decode(const std::vector<std::uint8_t>& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_memory(&image, file.data(), file.size()));
  image.format = PNG_FORMAT_RGB;
  Picture picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.rgb.resize(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr));
  return picture;
}

Canvas Sample() {
  Canvas canvas(5, 3);
  canvas.at(0, 0) = Srgb(0x123456);
  canvas.at(4, 0) = Srgb(0xFFFFFF);
  canvas.at(0, 2) = {9.0F, -1.0F, 0.0F};  // beyond what can be shown
  return canvas;
}

TEST(PngFile, KeepsEveryPixel) {
  const Picture picture = Decode(EncodePng(Sample()));
  ASSERT_EQ(picture.width, 5);
  ASSERT_EQ(picture.height, 3);
  const auto pixel = [&](int x, int y) {
    const auto* at = picture.rgb.data() + 3 * (5 * y + x);
    return at[0] << 16 | at[1] << 8 | at[2];
  };
  EXPECT_EQ(pixel(0, 0), 0x123456);
  EXPECT_EQ(pixel(4, 0), 0xFFFFFF);
  EXPECT_EQ(pixel(0, 2), 0xFF0000);
  EXPECT_EQ(pixel(2, 1), 0x000000);
}

TEST(PngFile, SrgbComesBackAsItWentIn) {
  Canvas canvas(256, 1);
  for (std::uint32_t i = 0; i < 256; ++i) canvas.at(static_cast<int>(i), 0) = Srgb(i);
  const Picture picture = Decode(EncodePng(canvas));
  for (std::size_t i = 0; i < 256; ++i) EXPECT_EQ(picture.rgb[3 * i + 2], i);
}

TEST(PngFile, WithAnAlphaChannelBlackIsTransparentAndOnBlackNothingChanges) {
  Canvas canvas(256, 2);
  for (std::uint32_t i = 0; i < 256; ++i) {
    canvas.at(static_cast<int>(i), 0) = Srgb(i << 16U | (i / 2) << 8U | (i / 3));
    canvas.at(static_cast<int>(i), 1) = Srgb(i << 16U | i << 8U | i);
  }
  const auto file = EncodePng(canvas, Opacity::kOfLight);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&image, file.data(), file.size()));
  EXPECT_TRUE(image.format & PNG_FORMAT_FLAG_ALPHA);
  image.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> rgba(PNG_IMAGE_SIZE(image));
  ASSERT_TRUE(png_image_finish_read(&image, nullptr, rgba.data(), 0, nullptr));
  for (int i = 0; i < 256; ++i) {
    const auto* at = rgba.data() + 4 * i;
    if (i == 0) {
      EXPECT_EQ(at[3], 0);
    }
    EXPECT_GE(at[3], i);
    // Two roundings, of the colour and of the product.
    EXPECT_NEAR(at[0] * at[3] / 255.0, i, 1.0);
    EXPECT_NEAR(at[1] * at[3] / 255.0, i / 2, 1.0);
    EXPECT_NEAR(at[2] * at[3] / 255.0, i / 3, 1.0);
  }
  // White stays white, and opaque.
  EXPECT_EQ(rgba[4 * 511 + 3], 255);
}

TEST(PngFile, TheFileHoldsTheBytes) {
  const std::filesystem::path path = test::FreshFolder() / "sample.png";
  ASSERT_TRUE(WritePng(path, Sample()).has_value());
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  const auto expected = EncodePng(Sample());
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()), expected);
}

TEST(PngFile, AFolderThatIsNotThereIsAnError) {
  const Status status = WritePng("/no/such/folder/views.png", Sample());
  ASSERT_FALSE(status.has_value());
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace intaglio::render
