#include "services/platform/command_line/nearest_word.h"

#include <gtest/gtest.h>

namespace intaglio::command_line {
namespace {

TEST(NearestWord, IsWhatWasProbablyMeant) {
  const std::vector<std::string> known = {"submit", "stop", "show", "list"};
  EXPECT_EQ(NearestWord("sumbit", known), "submit") << "two letters changed places";
  EXPECT_EQ(NearestWord("submt", known), "submit") << "left out";
  EXPECT_EQ(NearestWord("lists", known), "list") << "put in";
  EXPECT_EQ(NearestWord("shop", known), "stop") << "nearer ones first, then the first";
  EXPECT_EQ(NearestWord("engrave", known), std::nullopt);
  EXPECT_EQ(NearestWord("ls", known), std::nullopt) << "too short to say";
  EXPECT_EQ(NearestWord("", known), std::nullopt);
  EXPECT_EQ(NearestWord("list", {}), std::nullopt);
}

}  // namespace
}  // namespace intaglio::command_line
