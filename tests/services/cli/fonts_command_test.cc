#include "services/cli/fonts_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct FontsOutcome {
  int code = -1;
  std::string out, err;
};

FontsOutcome RunFonts(std::vector<std::string> words) {
  command_line::Program program("intaglio", "");
  AddFontsCommand(program.root());
  words.insert(words.begin(), "fonts");
  EXPECT_TRUE(program.Parse(words));
  FontsOutcome outcome;
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  outcome.code = program.Run();
  outcome.out = ::testing::internal::GetCapturedStdout();
  outcome.err = ::testing::internal::GetCapturedStderr();
  return outcome;
}

TEST(FontsCommand, ListsFamilyStyleAndFile) {
  const FontsOutcome all = RunFonts({});
  EXPECT_EQ(all.code, 0);
  EXPECT_THAT(all.out,
              AllOf(HasSubstr("FAMILY"), HasSubstr("DejaVu Sans"), HasSubstr("Bold"),
                    HasSubstr("DejaVuSans-Bold.ttf"), Not(HasSubstr("HAS OF THE TEXT"))));
  const FontsOutcome serif = RunFonts({"deja vu"});
  EXPECT_EQ(serif.code, 2);
  EXPECT_THAT(serif.err, HasSubstr("\"deja vu\""));
  EXPECT_THAT(RunFonts({"serif"}).out, Not(HasSubstr("DejaVu Sans")));
}

TEST(FontsCommand, ShowsWhichFontsHaveTheCharactersOfAText) {
  const FontsOutcome hebrew = RunFonts({"dejavu", "--text", "A\u05D0"});
  EXPECT_EQ(hebrew.code, 0);
  const auto sans = hebrew.out.find("DejaVuSans.ttf");
  const auto serif = hebrew.out.find("DejaVuSerif.ttf");
  ASSERT_NE(sans, std::string::npos);
  ASSERT_NE(serif, std::string::npos);
  EXPECT_LT(sans, serif) << "what has all comes first";
  EXPECT_THAT(hebrew.out, HasSubstr("not '\u05D0' (U+05D0)"));
  EXPECT_EQ(RunFonts({"--text", "\xC0\x80"}).code, 2);
}

}  // namespace
}  // namespace intaglio::cli
