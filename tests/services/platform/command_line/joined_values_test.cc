#include "services/platform/command_line/joined_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/platform/command_line/program.h"

namespace intaglio::command_line {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> Divide(const std::vector<std::string>& words) {
  return DivideJoinedValues(words, {"--block", "--rotate"});
}

TEST(JoinedValues, AreDividedBehindTheirOption) {
  EXPECT_THAT(Divide({"run", "--block", "50x50X80.5", "a.obj"}),
              ElementsAre("run", "--block", "50", "50", "80.5", "a.obj"));
  EXPECT_THAT(Divide({"--block=50,60,80"}), ElementsAre("--block", "50", "60", "80"));
  EXPECT_THAT(Divide({"--block", "50\u00d750\u00d780"}),
              ElementsAre("--block", "50", "50", "80"));
  EXPECT_THAT(Divide({"--rotate", "0,0,-90"}), ElementsAre("--rotate", "0", "0", "-90"));
}

TEST(JoinedValues, StayWholeElsewhere) {
  EXPECT_THAT(Divide({"--text", "50x50x80", "50x50x80.obj"}),
              ElementsAre("--text", "50x50x80", "50x50x80.obj"));
  EXPECT_THAT(Divide({"--block", "50", "50", "80"}),
              ElementsAre("--block", "50", "50", "80"));
  for (const char* word : {"50x50x", "50xy80", "x", "50 50 80"}) {
    EXPECT_THAT(Divide({"--block", word}), ElementsAre("--block", word));
  }
}

TEST(JoinedValues, AreCountedAsAnyOthers) {
  std::vector<double> block_mm;
  Program program("p", "");
  program.root().AddOption("--block", block_mm, "").TakeValues(3);
  ASSERT_TRUE(program.Parse({"--block", "50x50x80"}));
  EXPECT_THAT(block_mm, ElementsAre(50, 50, 80));
  const Status two = program.Parse({"--block", "50x50"});
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().message, HasSubstr("--block"));
}

}  // namespace
}  // namespace intaglio::command_line
