#include "materials_db/numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <random>

namespace intaglio::materials_db {
namespace {

using testing::ElementsAre;

TEST(Numbers, ReadsWhatCatalogsWrite) {
  EXPECT_EQ(ParseNumber("1.5"), 1.5);
  EXPECT_EQ(ParseNumber("+2"), 2.0);
  EXPECT_EQ(ParseNumber("-3.169E-003"), -0.003169);
  EXPECT_EQ(ParseNumber("2.276240300E+000"), 2.2762403);
  EXPECT_EQ(ParseNumber(".5"), 0.5);
}

TEST(Numbers, RefusesWhatIsNoFiniteNumber) {
  for (const char* text :
       {"", "-", "+", "+-1", "1.5x", "x", "1,5", "nan", "inf", "1e999", "0x10", " 1"}) {
    EXPECT_FALSE(ParseNumber(text)) << text;
  }
}

TEST(Numbers, ReadsLists) {
  EXPECT_THAT(*ParseNumbers(" 1 2\t3,4 ,5\r\n"), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_TRUE(ParseNumbers("")->empty());
  EXPECT_FALSE(ParseNumbers("1 two 3"));
}

TEST(Numbers, ComeBackBitForBit) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const auto number = std::bit_cast<double>(random());
    if (!(number - number == 0)) continue;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(*ParseNumber(FormatNumber(number))),
              std::bit_cast<std::uint64_t>(number));
  }
}

TEST(Numbers, SplitsWords) {
  EXPECT_THAT(SplitWords("  NM  N-BK7\t2 "), ElementsAre("NM", "N-BK7", "2"));
  EXPECT_TRUE(SplitWords(" \t").empty());
}

}  // namespace
}  // namespace intaglio::materials_db
