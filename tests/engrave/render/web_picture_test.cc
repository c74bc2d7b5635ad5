#include "engrave/render/web/web_picture.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace intaglio::render {
namespace {

/// Pixels that are brighter than the ground and have the hue of a colour.
int PixelsOf(const Canvas& canvas, const Color& color) {
  const auto shares = [](const Color& c) {
    const float sum = c.r + c.g + c.b;
    return std::array{c.r / sum, c.g / sum};
  };
  const auto wanted = shares(color);
  int count = 0;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      const Color& at = canvas.at(x, y);
      if (at.r + at.g + at.b < 0.3F) continue;
      const auto found = shares(at);
      count += std::abs(found[0] - wanted[0]) + std::abs(found[1] - wanted[1]) < 0.06F;
    }
  }
  return count;
}

WebPicture TwoLines() {
  return {{{{0, 0}, {10, 0}}, {{20, 0}, {30, 0}}}, {}, 20, "two lines", {"a figure"}};
}

TEST(WebPicture, HasMarksFromBlueToYellowAndMissedOnesRed) {
  WebPicture picture = TwoLines();
  const Canvas made = DrawWeb(picture);
  picture.missed = {false, true};
  const Canvas missed = DrawWeb(picture);
  const Color blue = Srgb(0x4f8fe0), yellow = Srgb(0xffc454), red = Srgb(0xff5050);
  EXPECT_GT(PixelsOf(made, blue), 100);
  EXPECT_GT(PixelsOf(made, yellow), 100);
  EXPECT_EQ(PixelsOf(made, red), 0);
  EXPECT_GT(PixelsOf(missed, red), 100);
  EXPECT_EQ(PixelsOf(missed, yellow), 0);
}

TEST(WebPicture, OfNothingIsAPictureToo) {
  const Canvas canvas = DrawWeb({});
  EXPECT_GT(canvas.width(), 0);
  EXPECT_GT(canvas.height(), 100);
}

}  // namespace
}  // namespace intaglio::render
