#include "engrave/render/text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace intaglio::render {
namespace {

/// A text as the bits of a small canvas.
std::vector<bool> Print(const std::string& text, double cap_px = 18.0) {
  Canvas canvas(80, 40);
  DrawText(canvas, {10, 28}, text, {.cap_height_px = cap_px});
  std::vector<bool> bits;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) bits.push_back(canvas.at(x, y).g > 0.5F);
  }
  return bits;
}

bool IsBlank(const std::vector<bool>& bits) {
  return std::find(bits.begin(), bits.end(), true) == bits.end();
}

TEST(Text, EveryAsciiSignIsThereAndDifferent) {
  std::set<std::vector<bool>> seen;
  for (char sign = '!'; sign <= '~'; ++sign) {
    const auto bits = Print(std::string(1, sign));
    EXPECT_FALSE(IsBlank(bits)) << sign;
    EXPECT_TRUE(seen.insert(bits).second) << sign << " looks like another sign";
  }
  EXPECT_TRUE(IsBlank(Print(" ")));
}

TEST(Text, SignsOfFiguresAreThere) {
  const auto box = Print("\xEF\xBF\xBD");  // characters that the font does not have
  for (const char* sign : {"µ", "°", "±", "×", "·", "–", "²", "³"}) {
    EXPECT_FALSE(IsBlank(Print(sign))) << sign;
    EXPECT_NE(Print(sign), box) << sign;
  }
  EXPECT_EQ(Print("漢"), box);
}

TEST(Text, BrokenUtf8ShowsAsBoxesAndDoesNotRunOn) {
  const auto box = Print("\xEF\xBF\xBD");
  EXPECT_EQ(Print("\x80"), box);
  EXPECT_EQ(Print("\xC2"), box);
  EXPECT_EQ(Print("\xE2\x80"), box);
  EXPECT_EQ(Print("\xFF"), box);
}

TEST(Text, DigitsHaveEqualWidths) {
  const double width = TextWidth("0", 10);
  for (char digit = '1'; digit <= '9'; ++digit) {
    EXPECT_EQ(TextWidth(std::string(1, digit), 10), width) << digit;
  }
  EXPECT_EQ(TextWidth("", 10), 0.0);
  EXPECT_GT(TextWidth("a b", 10), TextWidth("ab", 10));
  EXPECT_NEAR(TextWidth("mm", 20), 2 * TextWidth("mm", 10), 1e-9);
}

TEST(Text, IsOnItsBaselineAtItsPlace) {
  for (const auto& [align, left, right] :
       {std::tuple{Align::kLeft, 40, 80}, std::tuple{Align::kCenter, 20, 60},
        std::tuple{Align::kRight, 0, 40}}) {
    Canvas canvas(80, 40);
    DrawText(canvas, {40, 30}, "HH", {.cap_height_px = 18, .align = align});
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 80; ++x) {
        if (canvas.at(x, y).r < 0.5F) continue;
        EXPECT_GE(x, left - 2);
        EXPECT_LE(x, right + 2);
        EXPECT_GE(y, 30 - 18 - 2);
        EXPECT_LE(y, 30 + 1);
      }
    }
  }
}

TEST(Text, LongTextsLeaveTheCanvasUnharmed) {
  Canvas canvas(20, 10);
  DrawText(canvas, {-100, 5}, std::string(500, 'W'), {.cap_height_px = 30});
  SUCCEED();
}

}  // namespace
}  // namespace intaglio::render
