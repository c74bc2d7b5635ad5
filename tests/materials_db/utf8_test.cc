#include "materials_db/utf8.h"

#include <gtest/gtest.h>

namespace intaglio::materials_db {
namespace {

using namespace std::string_literals;

TEST(Utf8, KnowsItsOwnForms) {
  EXPECT_TRUE(IsUtf8(""));
  EXPECT_TRUE(IsUtf8("N-BK7"));
  EXPECT_TRUE(IsUtf8("20 °C, 0.21–3.71 μm, 𝜆"));
}

// RFC 3629, section 10: what a decoder must not accept.
TEST(Utf8, RefusesWhatIsMalformed) {
  EXPECT_FALSE(IsUtf8("\xC0\x80"));          // overlong NUL
  EXPECT_FALSE(IsUtf8("\xE0\x9F\xBF"));      // overlong, three bytes
  EXPECT_FALSE(IsUtf8("\xF0\x8F\xBF\xBF"));  // overlong, four bytes
  EXPECT_FALSE(IsUtf8("\xED\xA0\x80"));      // surrogate
  EXPECT_FALSE(IsUtf8("\xF4\x90\x80\x80"));  // above U+10FFFF
  EXPECT_FALSE(IsUtf8("\xE2\x82"));          // cut off
  EXPECT_FALSE(IsUtf8("\xEF\xBF\xBF"));      // U+FFFF, a noncharacter
  EXPECT_FALSE(IsUtf8("\xEF\xB7\x90"));      // U+FDD0, another
  EXPECT_FALSE(IsUtf8("\x80"));              // a tail without a head
  EXPECT_FALSE(IsUtf8("\xE2\x28\xA1"));      // a head without its tail
}

TEST(Utf8, EveryCharacterIsWrittenWellFormed) {
  for (char32_t c = 0; c <= 0x10FFFF; c += 1 + c / 64) {
    if (!IsCharacter(c)) continue;
    std::string text;
    AppendUtf8(text, c);
    EXPECT_TRUE(IsUtf8(text)) << std::hex << static_cast<unsigned>(c);
  }
}

TEST(Utf8, ReadsWhatGlassCatalogsAreWrittenIn) {
  EXPECT_EQ(ToUtf8("plain"), "plain");
  EXPECT_EQ(ToUtf8("\xEF\xBB\xBFwith a mark"), "with a mark");
  EXPECT_EQ(ToUtf8("20 \xB0"
                   "C"),
            "20 °C");                                      // Latin-1
  EXPECT_EQ(ToUtf8("\xFF\xFEN\0M\0\xB0\0"s), "NM°");       // little endian
  EXPECT_EQ(ToUtf8("\xFE\xFF\0N\0M\0\xB0"s), "NM°");       // big endian
  EXPECT_EQ(ToUtf8("\xFF\xFE\x35\xD8\x06\xDF"s), "𝜆");     // a pair
  EXPECT_EQ(ToUtf8("\xFF\xFE\x35\xD8"s), "\xEF\xBF\xBD");  // half a pair
  EXPECT_EQ(ToUtf8("\xFF\xFEN\0M"s), "N");                 // half a unit
}

}  // namespace
}  // namespace intaglio::materials_db
