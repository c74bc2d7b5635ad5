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
}

/// How bright the middle of a pixel is in a text of this height, its first letter at x 10
/// with the baseline y 28.
float At(const std::string& text, double cap_px, double right_px, double up_px) {
  Canvas canvas(120, 40);
  DrawText(canvas, {10, 28}, text, {.cap_height_px = cap_px});
  return canvas.at(static_cast<int>(10 + right_px), static_cast<int>(28 - up_px)).g;
}

// Names in other scripts come from the fonts of the computer: the stems and the bar of a
// Cyrillic H, and the ring of an O, by the form of the letters.
TEST(Text, LettersOfOtherScriptsAreThoseOfAFont) {
  const double width = TextWidth("Н", 20);  // U+041D
  EXPECT_NEAR(width, 15, 3) << "as high as 20";
  EXPECT_GT(At("Н", 20, width - 1.5, 3), 0.9F) << "right stem, which ends its width";
  EXPECT_GT(At("Н", 20, width - 1.5, 18), 0.9F);
  EXPECT_LT(At("Н", 20, width / 2, 4), 0.1F) << "below the bar";
  EXPECT_GT(At("Н", 20, width / 2, 10.5), 0.9F) << "the bar";
  EXPECT_LT(At("Н", 20, width / 2, 22), 0.1F) << "a capital is 20 high";
  EXPECT_LT(At("О", 20, TextWidth("О", 20) / 2, 10), 0.1F) << "the hole of U+041E";
  EXPECT_NE(Print("Ваня"), Print("Вася"));
  // A Latin word beside it keeps its place.
  EXPECT_GT(TextWidth("Ivan Ваня", 10),
            TextWidth("Ivan ", 10) + TextWidth("Ваня", 10) - 1);
}

// Arabic letters are joined: in the middle of the word there is ink from its one end to
// the other, and the word is shorter than its letters one by one.
TEST(Text, LettersOfAScriptAreJoined) {
  EXPECT_LT(TextWidth("بيت", 20),
            TextWidth("ب", 20) + TextWidth("ي", 20) + TextWidth("ت", 20));
}

TEST(Text, ACharacterThatNoFontHasIsDrawnAsItsNumber) {
  // The letters beside it are not lost.
  const std::string unknown = "\xF3\xB0\x80\x80";
  EXPECT_NEAR(TextWidth("Н" + unknown, 9),
              TextWidth("Н", 9) + 2.3 + TextWidth("<F0000>", 9), 0.01);
  EXPECT_NEAR(TextWidth("بيت " + unknown, 9),
              TextWidth("بيت", 9) + TextWidth(" ", 9) + 4.6 + TextWidth("<F0000>", 9),
              0.01);
  EXPECT_EQ(Print("\xF3\xB0\x80\x80", 6), Print("<F0000>", 6)) << "for private use";
}

TEST(Text, LettersOfNamesHaveTheirMarks) {
  const auto box = Print("\xEF\xBF\xBD");
  std::set<std::vector<bool>> seen;
  for (const char* sign :
       {"A", "Á", "À", "Â", "Ä", "Ã", "Å", "Ą", "Ă", "Ā", "a", "á", "à", "â",
        "ä", "ã", "å", "ą", "o", "ó", "ö", "ő", "ø", "u", "ü", "ű", "ů", "l",
        "ł", "L", "Ł", "c", "ç", "č", "ć", "i", "í", "ï", "ı", "s", "š", "ş",
        "ß", "z", "ž", "ż", "d", "đ", "n", "ñ", "g", "ğ", "æ", "Æ"}) {
    const auto bits = Print(sign);
    EXPECT_NE(bits, box) << sign;
    EXPECT_TRUE(seen.insert(bits).second) << sign << " looks like another sign";
  }
  // The mark does not change the place of the next letter.
  EXPECT_EQ(TextWidth("ä", 10), TextWidth("a", 10));
}

TEST(Text, BrokenUtf8ShowsAsBoxesAndDoesNotRunOn) {
  const auto box = Print("\xEF\xBF\xBD");
  EXPECT_EQ(Print("\x80"), box);
  EXPECT_EQ(Print("\xC2"), box);
  EXPECT_EQ(Print("\xE2\x80"), box);
  EXPECT_EQ(Print("\xFF"), box);
}

TEST(Text, WrappedLinesFitAndLoseNothing) {
  const std::string text =
      "the surface has a hole of radius 1.75 mm at (27.93, 18.02) mm";
  for (const double width : {60.0, 150.0, 400.0, 4000.0}) {
    std::string joined;
    for (const std::string& line : WrapText(text, 10, width)) {
      EXPECT_LE(TextWidth(line, 10), width) << line;
      joined += (joined.empty() ? "" : " ") + line;
    }
    // Below the width of its widest token the text is broken elsewhere, too.
    if (width >= 100) {
      EXPECT_EQ(joined, text);
    }
  }
  EXPECT_EQ(WrapText(text, 10, 4000).size(), 1u);
  EXPECT_TRUE(WrapText("", 10, 100).empty());
}

TEST(Text, ATokenWiderThanTheLineIsBrokenBetweenCharacters) {
  const std::string token = "\xC2\xB5\xC2\xB5\xC2\xB5\xC2\xB5\xC2\xB5\xC2\xB5";
  std::string joined;
  for (const std::string& line : WrapText(token, 10, 25)) {
    EXPECT_EQ(line.size() % 2, 0u);  // a micro sign is two bytes
    EXPECT_LE(TextWidth(line, 10), 25);
    joined += line;
  }
  EXPECT_EQ(joined, token);
  // Narrower than any character: one a line, and it ends.
  EXPECT_EQ(WrapText("abc", 10, 1).size(), 3u);
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
