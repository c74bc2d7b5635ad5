#include "services/platform/command_line/man_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/platform/command_line/option_text.h"
#include "tests/services/platform/command_line/sample_commands.h"

namespace intaglio::command_line {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(ManPage, IsMadeOfTheProgramAndOfEachCommand) {
  const auto pages = ManPagesOf("shop", SampleCommands());
  ASSERT_EQ(pages.size(), 3u);
  EXPECT_EQ(pages[0].file_name, "shop.1");
  EXPECT_EQ(pages[1].file_name, "shop-run.1");
  EXPECT_EQ(pages[2].file_name, "shop-recording.1");
  EXPECT_THAT(pages[0].text,
              AllOf(HasSubstr(".TH \"SHOP\" 1"), HasSubstr("shop \\- engraves; it's"),
                    HasSubstr("\\fBrun\\fR\nengrave one job. See \\fBshop\\-run\\fR(1)."),
                    HasSubstr("\\fBshop\\-run\\fR(1),\n\\fBshop\\-recording\\fR(1)")));
}

TEST(ManPage, HasAllThatIsKnownOfAnOption) {
  const std::string text = ManPagesOf("shop", SampleCommands())[1].text;
  EXPECT_THAT(text,
              HasSubstr(".TP\n\\fB\\-\\-order\\fR \\fITEXT\\fR\norder of the points. "
                        "One of: anneal, layers. Default: anneal.\n"));
  EXPECT_THAT(text, HasSubstr(".SH \"OF THE BUS\"\n.TP\n\\fB\\-\\-domain\\fR, "
                              "\\fB\\-\\-dds\\-domain\\fR \\fIN\\fR\n"));
  EXPECT_THAT(text, HasSubstr("Required. Range: 0..99. Environment: SHOP_DOMAIN.\n"));
  EXPECT_THAT(text, HasSubstr("\\fBshop run\\fR [\\fIOPTION\\fR]... [\\fIJOB\\fR]\n"));
  EXPECT_THAT(text, Not(HasSubstr("private")));
}

TEST(ManPage, HasTheCommandsBelowACommandAsSections) {
  const std::string text = ManPagesOf("shop", SampleCommands())[2].text;
  EXPECT_THAT(text, HasSubstr(".SH \"shop recording info\"\nwhat is in it.\n"));
  EXPECT_THAT(
      text,
      HasSubstr(".SH \"shop recording cut\"\na span of time.\n.PP\n"
                "\\fBshop recording cut\\fR [\\fIOPTION\\fR]...\n.SS \"Options\"\n"));
}

// A line that begins with a dot is a request of troff: it would vanish.
TEST(ManPage, PrintsDotsAtTheBeginningOfALine) {
  const auto pages = ManPagesOf("shop", SampleCommands());
  EXPECT_THAT(pages[0].text, HasSubstr("\n\\&.a line that begins with a dot\n"));
  EXPECT_THAT(pages[1].text, HasSubstr("\n\\&.textproto file.\n"));
}

TEST(OptionText, ReadsKindAndRange) {
  const auto option = [](const char* value) {
    OptionDescription made;
    made.value = value;
    return made;
  };
  EXPECT_EQ(PlaceholderOf(option("FLOAT:FLOAT in [0.01 - 1000]")), "NUMBER");
  EXPECT_EQ(RangeOf(option("FLOAT:FLOAT in [0.01 - 1000]")), "0.01..1000");
  EXPECT_EQ(RangeOf(option("FLOAT:FLOAT in [-200 - 200]")), "-200..200");
  EXPECT_EQ(RangeOf(option("FLOAT:POSITIVE")), "above 0");
  EXPECT_EQ(RangeOf(option("TEXT")), "");
  EXPECT_EQ(PlaceholderOf(option("UINT")), "N");
  EXPECT_EQ(PlaceholderOf(option("")), "");
}

}  // namespace
}  // namespace intaglio::command_line
