#include "services/cli/flags/text_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TextFlags TextTyped(const std::vector<std::string>& words) {
  command_line::Program program("intaglio", "");
  TextFlags flags;
  AddTextFlags(program.root(), flags);
  EXPECT_TRUE(program.Parse(words));
  return flags;
}

TEST(TextFlags, MakeATextOfAJobThatHasNone) {
  JobSpec job;
  job.add_models()->set_file("cup.stl");
  ASSERT_TRUE(SetTexts(
      TextTyped({"--text", "Anna\\nBerta", "--text-height", "8", "--fallback-font",
                 "Noto Sans", "DejaVu Sans", "--shrink-to-fit"}),
      job));
  ASSERT_EQ(job.models_size(), 2);
  const Text& text = job.models(1).text();
  EXPECT_EQ(text.text(), "Anna\nBerta");
  EXPECT_EQ(text.font(), "DejaVu Sans");
  EXPECT_EQ(text.height_mm(), 8);
  EXPECT_TRUE(text.shrink_to_fit());
  EXPECT_THAT(text.fallback_fonts(), ElementsAre("Noto Sans", "DejaVu Sans"));
}

TEST(TextFlags, ReplaceTheOneTextOfAJobAndLeaveTheRestOfIt) {
  JobSpec job;
  job.add_models()->mutable_text()->set_text("{name}");
  job.mutable_models(0)->mutable_text()->set_font("Serif");
  job.mutable_models(0)->mutable_text()->set_height_mm(3);
  ASSERT_TRUE(SetTexts(TextTyped({"--text", "Anna"}), job));
  ASSERT_EQ(job.models_size(), 1);
  EXPECT_EQ(job.models(0).text().text(), "Anna");
  EXPECT_EQ(job.models(0).text().font(), "Serif");
  EXPECT_EQ(job.models(0).text().height_mm(), 3);
}

TEST(TextFlags, ThatDoNotApplyAreRefused) {
  JobSpec none;
  EXPECT_THAT(SetTexts(TextTyped({"--font", "Serif"}), none).error().message,
              HasSubstr("--font: the job has no text"));
  JobSpec two;
  two.add_models()->mutable_text()->set_text("a");
  two.add_models()->mutable_text()->set_text("b");
  EXPECT_THAT(SetTexts(TextTyped({"--text", "Anna"}), two).error().message,
              HasSubstr("the job has 2 texts"));
  ASSERT_TRUE(SetTexts(TextTyped({"--font", "Serif"}), two));
  EXPECT_EQ(two.models(1).text().font(), "Serif");
}

}  // namespace
}  // namespace intaglio::cli
