// --accept: warnings and answers, each for the commands that can use them.

#include "services/cli/flags/accept_flag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/services/cli/all_commands.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;

Result<AcceptFlag> Typed(void (*add)(command_line::Command, AcceptFlag&),
                         const std::vector<std::string>& words) {
  AcceptFlag flag;
  command_line::Program program("intaglio", "");
  add(program.root(), flag);
  if (auto parsed = program.Parse(words); !parsed) return tl::unexpected(parsed.error());
  return flag;
}

TEST(AcceptFlag, AnswersSetTheirOptions) {
  const auto flag = Typed(AddAcceptAndAnswers, {"--accept", "up=-y", "--accept",
                                                "unit=25.4", "--accept", "breakage"});
  ASSERT_TRUE(flag) << flag.error().message;
  EXPECT_TRUE(flag->breakage());
  JobFlags job;
  ASSERT_TRUE(TakeAnswers(*flag, job));
  EXPECT_EQ(job.up, "-y");
  EXPECT_EQ(job.unit_mm, 25.4);
}

TEST(AcceptFlag, AnAnswerIsNoConsent) {
  const auto flag = Typed(AddAnswers, {"--accept", "up=z"});
  ASSERT_TRUE(flag) << flag.error().message;
  EXPECT_FALSE(flag->breakage());
}

TEST(AcceptFlag, TwoAnswersToOneQuestionAreRefused) {
  JobFlags job;
  job.up = "z";
  EXPECT_TRUE(TakeAnswers({{"up=z"}}, job)) << "the same twice";
  const Status refused = TakeAnswers({{"up=y"}}, job);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("--accept up=y"));
  job.unit_mm = 1;
  EXPECT_FALSE(TakeAnswers({{"unit=1000"}}, job));
}

// The question about a mesh names the answer: discretize and post refused it.
TEST(AcceptFlag, EveryCommandThatMayAskTakesTheAnswer) {
  const auto has = [](const command_line::CommandDescription& command,
                      const std::string& name) {
    return std::any_of(command.options.begin(), command.options.end(),
                       [&](const auto& option) { return option.names.front() == name; });
  };
  std::size_t asking = 0;
  for (const auto& command : AllCommands()) {
    if (!has(command, "--up")) continue;
    ++asking;
    EXPECT_TRUE(has(command, "--accept"))
        << fmt::format("{}", fmt::join(command.words, " "));
  }
  EXPECT_GE(asking, 5u);
}

TEST(AcceptFlag, ACommandTakesWhatItCanUse) {
  EXPECT_FALSE(Typed(AddAcceptFlag, {"--accept", "up=y"}));
  EXPECT_FALSE(Typed(AddAnswers, {"--accept", "breakage"}));
  EXPECT_FALSE(Typed(AddAcceptAndAnswers, {"--accept", "up=w"}));
}

}  // namespace
}  // namespace intaglio::cli
