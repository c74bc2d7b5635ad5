// The supplied fonts differ: DejaVu Serif has no Hebrew letters, DejaVu Sans has; neither
// has a unicorn.

#include "engrave/drawing/text_coverage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/drawing/font_list.h"
#include "engrave/drawing/utf8_characters.h"

namespace intaglio::drawing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kSerif = "DejaVu Serif";
constexpr const char* kSans = "DejaVu Sans";
constexpr const char* kAleph = "\u05D0";
constexpr const char* kUnicorn = "\U0001F984";

std::string FileOf(const char* family) { return FindFontFile(family).value_or(""); }

TEST(TextCoverage, NamesWhatEachFontOfTheListAdds) {
  const std::vector<FontSource> fonts = {{kSerif}, {kSans}};
  const auto coverage = CoverageOf(std::string("A") + kAleph + "A" + kAleph, fonts);
  ASSERT_TRUE(coverage) << coverage.error().message;
  EXPECT_THAT(coverage->missing, IsEmpty());
  ASSERT_EQ(coverage->borrowed.size(), 1u);
  EXPECT_EQ(coverage->borrowed.at(1), U"\u05D0") << "once";
  EXPECT_TRUE(CheckCoverage(*coverage));
}

TEST(TextCoverage, WhatIsMissingHasItsCodePointItsLineAndTheFonts) {
  const std::vector<FontSource> fonts = {{kSerif}, {kSans}};
  const auto coverage =
      CoverageOf(std::string("Anna\r\n") + kUnicorn + "\x01" + kUnicorn, fonts);
  ASSERT_TRUE(coverage);
  const auto checked = CheckCoverage(*coverage);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, ErrorCode::kMissing);
  EXPECT_THAT(checked.error().message, AllOf(HasSubstr(std::string("'") + kUnicorn +
                                                       "' (U+1F984) in line 2, U+0001"),
                                             HasSubstr("DejaVu Serif, DejaVu Sans")));
  EXPECT_EQ(CoverageOf("\xC0\x80", fonts).error().code, ErrorCode::kUnreadable);
  EXPECT_EQ(CoverageOf("A", std::vector<FontSource>{{"No Such Family"}}).error().code,
            ErrorCode::kNotFound);
}

TEST(TextCoverage, OnlyFontsThatAddACharacterAreNeeded) {
  const std::vector<std::string> candidates = {FileOf("DejaVu Sans Mono"), FileOf(kSans),
                                               "/no/such/font.ttf",
                                               FileOf("DejaVu Sans:Bold")};
  const auto needed = NeededFallbacks(std::string("A") + kAleph, kSerif, candidates);
  ASSERT_TRUE(needed);
  EXPECT_THAT(*needed, ElementsAre(FileOf(kSans)));
  EXPECT_THAT(*NeededFallbacks("Anna", kSerif, candidates), IsEmpty());
}

TEST(TextCoverage, TheComputersFontsAreTheFallbacks) {
  const auto found = InstalledFallbacks(std::string("A") + kAleph, kSerif);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->size(), 1u);
  EXPECT_THAT(*InstalledFallbacks("Anna", kSerif), IsEmpty());
}

TEST(FontList, ListsEveryFontWithItsFamilyStyleAndFile) {
  bool bold = false;
  for (const InstalledFont& font : InstalledFonts()) {
    EXPECT_FALSE(font.family.empty());
    EXPECT_TRUE(IsFontFile(font.file)) << font.file;
    bold = bold || (font.family == kSans && font.style == "Bold");
  }
  EXPECT_TRUE(bold);
}

TEST(FontList, AFamilyThatIsNotInstalledIsAnsweredWithNearOnes) {
  const auto found = FindFontFile("DejaVoo Sans");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(found.error().message, HasSubstr("did you mean DejaVu Sans"));
  EXPECT_THAT(FindFontFile("Xyzzy").error().message,
              AllOf(HasSubstr("intaglio fonts"), Not(HasSubstr("did you mean"))));
}

TEST(FontList, FallbacksBeginWithUsualFontsAndNameNoneTwice) {
  const auto files = FallbackFontFiles(U"\u05D0");
  EXPECT_THAT(files, Contains(FileOf(kSans)));
  for (const std::string& file : files) {
    EXPECT_EQ(std::count(files.begin(), files.end(), file), 1) << file;
  }
}

TEST(Utf8Characters, TextsComeBack) {
  const std::string text = "Aß€\U0001F984";
  const auto characters = CharactersOf(text);
  ASSERT_TRUE(characters);
  EXPECT_EQ(*characters, U"Aß€\U0001F984");
  EXPECT_EQ(Utf8Of(*characters), text);
  EXPECT_EQ(NameOfCharacter(U'ß'), "'ß' (U+00DF)");
  EXPECT_EQ(NameOfCharacter(U'\u0301'), "U+0301") << "combines with the quotation mark";
}

}  // namespace
}  // namespace intaglio::drawing
