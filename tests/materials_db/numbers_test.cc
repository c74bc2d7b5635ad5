#include "materials_db/numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <random>

#include "engrave/io/number_text.h"

namespace intaglio::materials_db {
namespace {

using testing::ElementsAre;

TEST(Numbers, ReadsLists) {
  EXPECT_THAT(*ParseNumbers(" 1 2\t3,4 ,5\r\n"), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_TRUE(ParseNumbers("")->empty());
  EXPECT_FALSE(ParseNumbers("1 two 3"));
  EXPECT_FALSE(ParseNumbers("1 1e999"));
}

TEST(Numbers, ComeBackBitForBit) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const auto number = std::bit_cast<double>(random());
    if (!(number - number == 0)) continue;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(*io::ParseFinite(FormatNumber(number))),
              std::bit_cast<std::uint64_t>(number));
  }
}

TEST(Numbers, SplitsTokens) {
  EXPECT_THAT(SplitTokens("  NM  N-BK7\t2 "), ElementsAre("NM", "N-BK7", "2"));
  EXPECT_TRUE(SplitTokens(" \t").empty());
}

}  // namespace
}  // namespace intaglio::materials_db
