#include "materials_db/html_text.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace intaglio::materials_db {
namespace {

TEST(HtmlText, DropsTagsAndKeepsLines) {
  EXPECT_EQ(
      TextFromHtml("<a href=\"https://x.y/z?a=1&b=2\"><i>Sol. Energy</i> <b>12</b>, "
                   "275 (1985)</a>"),
      "Sol. Energy 12, 275 (1985)");
  EXPECT_EQ(TextFromHtml("  1) Malitson.<br>\n    2) Tan. <BR/> 3)"),
            "1) Malitson.\n2) Tan.\n3)");
}

TEST(HtmlText, DecodesEntities) {
  EXPECT_EQ(TextFromHtml("a &amp; b &lt;c&gt; 5&nbsp;&#181;m &#x3BB; &unknown; & &;"),
            "a & b <c> 5 µm λ &unknown; & &;");
  // Not a character: kept unchanged.
  EXPECT_EQ(TextFromHtml("&#xD800; &#0; &#99999999;"), "&#xD800; &#0; &#99999999;");
}

TEST(HtmlText, KeepsWhatIsNoTag) {
  EXPECT_EQ(TextFromHtml("n < 2 and > 1"), "n < 2 and > 1");
  EXPECT_EQ(TextFromHtml("an open <tag"), "an open <tag");
}

// Random text of the characters that matter, against the definition.
TEST(HtmlText, ComesBackUnchanged) {
  constexpr char kAlphabet[] = " \t\n<>&;#ab/\"'1";
  std::mt19937 random(7);
  std::uniform_int_distribution<std::size_t> pick(0, sizeof kAlphabet - 2);
  for (int i = 0; i < 5000; ++i) {
    std::string text(pick(random), ' ');
    for (char& c : text) c = kAlphabet[pick(random)];
    EXPECT_EQ(TextFromHtml(HtmlFromText(text)), text);
  }
}

}  // namespace
}  // namespace intaglio::materials_db
