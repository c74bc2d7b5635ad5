#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "engrave/image/image_file.h"
#include "tests/engrave/image/pictures.h"

namespace intaglio::image {
namespace {

using ::testing::HasSubstr;

struct PcxKind {
  unsigned depth = 8, planes = 1;
  bool packed = true;
  std::vector<Rgb> palette = {};  // 16 in the header, 256 at the end
};

/// ZSoft's manual: a value of two upper bits, or one that repeats, is written as a run.
std::string Packed(const std::string& row) {
  std::string packed;
  for (std::size_t i = 0; i < row.size();) {
    std::size_t count = 1;
    while (count < 63 && i + count < row.size() && row[i + count] == row[i]) ++count;
    if (count > 1 || static_cast<unsigned char>(row[i]) >= 0xC0) {
      packed.push_back(static_cast<char>(0xC0 + count));
    }
    packed.push_back(row[i]);
    i += count;
  }
  return packed;
}

/// `rows`: the planes of each row, one behind the other.
std::string EncodePcx(unsigned width, const std::vector<std::string>& rows,
                      const PcxKind& kind) {
  std::string file(128, '\0');
  const auto put = [&file](std::size_t at, unsigned value) {
    file[at] = static_cast<char>(value & 255U);
  };
  put(0, 10), put(1, 5), put(2, kind.packed ? 1 : 0), put(3, kind.depth);
  put(8, width - 1), put(10, static_cast<unsigned>(rows.size()) - 1);
  put(65, kind.planes);
  put(66, static_cast<unsigned>(rows.front().size()) / kind.planes);
  for (std::size_t i = 0; i < kind.palette.size() && i < 16; ++i) {
    put(16 + 3 * i, kind.palette[i].r);
    put(17 + 3 * i, kind.palette[i].g);
    put(18 + 3 * i, kind.palette[i].b);
  }
  for (const std::string& row : rows) file += kind.packed ? Packed(row) : row;
  if (kind.palette.size() == 256) {
    file.push_back(12);
    for (const Rgb& c : kind.palette) {
      for (const auto v : {c.r, c.g, c.b}) file.push_back(static_cast<char>(v));
    }
  }
  return file;
}

std::vector<Rgb> RandomColours(std::size_t count) {
  std::mt19937_64 random(5);
  std::vector<Rgb> colours(count);
  for (Rgb& c : colours) {
    c = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
         static_cast<std::uint8_t>(random())};
  }
  return colours;
}

GreyImage Parsed(const std::string& file) {
  const auto image = ParseImage(file);
  EXPECT_TRUE(image) << (image ? "" : image.error().message);
  return image ? *image : GreyImage{};
}

TEST(Pcx, OneBitAPixelIsBlackAndWhite) {
  const GreyImage image = Parsed(EncodePcx(10, {"\xb1\x40", "\x20\xff"}, {.depth = 1}));
  const std::vector<int> expected = {1, 0, 1, 1, 0, 0, 0, 1, 0, 1};
  ASSERT_EQ(image.width, 10);
  ASSERT_EQ(image.height, 2);
  for (int x = 0; x < 10; ++x) {
    EXPECT_EQ(image.at(x, 0), 65535 * expected[static_cast<std::size_t>(x)]);
    EXPECT_EQ(image.at(x, 1), x == 2 || x > 7 ? 65535 : 0);
  }
}

TEST(Pcx, PalettesOf16And256Colours) {
  PcxKind kind;
  kind.palette = RandomColours(256);
  for (const bool packed : {false, true}) {
    kind.packed = packed;
    std::string row;
    for (int x = 0; x < 250; ++x) row.push_back(static_cast<char>(x));
    const GreyImage image = Parsed(EncodePcx(250, {row, row}, kind));
    for (int x = 0; x < 250; ++x) {
      EXPECT_NEAR(image.at(x, 1),
                  65535 * LuminanceOf(kind.palette[static_cast<std::size_t>(x)]), 0.6);
    }
  }
  kind.palette.resize(16);
  // Four planes of a bit: pixel 0 is colour 1 + 8, pixel 1 colour 2 + 4.
  kind.depth = 1, kind.planes = 4;
  const GreyImage planes =
      Parsed(EncodePcx(2, {std::string("\x80\x40\x40\x80", 4)}, kind));
  EXPECT_NEAR(planes.at(0, 0), 65535 * LuminanceOf(kind.palette[9]), 0.6);
  EXPECT_NEAR(planes.at(1, 0), 65535 * LuminanceOf(kind.palette[6]), 0.6);
  kind.depth = 4, kind.planes = 1;
  const GreyImage nibbles = Parsed(EncodePcx(2, {"\x96"}, kind));
  EXPECT_EQ(nibbles.samples, planes.samples);
}

TEST(Pcx, TrueColourAndGreyWithoutAPalette) {
  const std::vector<Rgb> colours = RandomColours(40);
  std::string red, green, blue;
  for (const Rgb& c : colours) {
    red.push_back(static_cast<char>(c.r));
    green.push_back(static_cast<char>(c.g));
    blue.push_back(static_cast<char>(c.b));
  }
  const GreyImage image = Parsed(EncodePcx(40, {red + green + blue}, {.planes = 3}));
  for (int x = 0; x < 40; ++x) {
    EXPECT_NEAR(image.at(x, 0), 65535 * LuminanceOf(colours[static_cast<std::size_t>(x)]),
                0.6);
  }
  const GreyImage grey = Parsed(EncodePcx(40, {red}, {}));
  EXPECT_NEAR(grey.at(3, 0),
              65535 * LuminanceOf({colours[3].r, colours[3].r, colours[3].r}), 0.6);
}

TEST(Pcx, DamageIsAnErrorThatNamesItsPlace) {
  const std::string file = EncodePcx(10, {"\xb1\x40", "\x20\xff"}, {.depth = 1});
  const auto message = [](const std::string& bytes) {
    const auto image = ParseImage(bytes);
    EXPECT_FALSE(image);
    return image ? "" : image.error().message;
  };
  EXPECT_THAT(message(file.substr(0, 100)), HasSubstr("within its header"));
  EXPECT_THAT(message(file.substr(0, file.size() - 1)), HasSubstr("row 1 of 2"));
  std::string wrong = file;
  wrong[66] = 1;
  EXPECT_THAT(message(wrong), HasSubstr("rows of 1 byte for 10 pixels"));
  wrong = file;
  wrong[65] = 7;
  EXPECT_THAT(message(wrong), HasSubstr("7 planes of 1 bit"));
  wrong = file;
  wrong[8] = 0, wrong[4] = 5;
  EXPECT_THAT(message(wrong), HasSubstr("no pixels"));
}

}  // namespace
}  // namespace intaglio::image
