#include "engrave/io/number_text.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>

namespace intaglio::io {
namespace {

TEST(NumberText, ReadsWhatPeopleAndProgramsWrite) {
  EXPECT_EQ(ParseNumber("1.5"), 1.5);
  EXPECT_EQ(ParseNumber("+2"), 2.0);
  EXPECT_EQ(ParseNumber("-3.169E-003"), -0.003169);
  EXPECT_EQ(ParseNumber("2.276240300E+000"), 2.2762403);
  EXPECT_EQ(ParseNumber(".5"), 0.5);
  EXPECT_TRUE(std::isnan(*ParseNumber("nan")));
  EXPECT_EQ(ParseNumber("-inf"), -std::numeric_limits<double>::infinity());
}

TEST(NumberText, RefusesWhatIsNoNumber) {
  for (const char* text :
       {"", "-", "+", "+-1", "++1", "1.5x", "x", "1,5", "0x10", " 1", "1 ", "1e"}) {
    EXPECT_FALSE(ParseNumber(text)) << text;
    EXPECT_FALSE(ParseNumber<float>(text)) << text;
    EXPECT_FALSE(ParseFinite(text)) << text;
  }
}

TEST(NumberText, FiniteIsNeitherInfiniteNorNan) {
  EXPECT_EQ(ParseFinite("1.5"), 1.5);
  for (const char* text : {"nan", "inf", "-inf", "1e999", "-1e999"}) {
    EXPECT_FALSE(ParseFinite(text)) << text;
  }
}

// strtod and strtof round to the nearest, and saturate as IEEE 754 does.
TEST(NumberText, OutOfRangeSaturates) {
  for (const char* text : {"1e400", "-1e400", "1E-400", "-1e-400", "1e39", "-1e39",
                           "1e-50", "-1e-50", "1e-44", "3.4028236e38"}) {
    const double expected = std::strtod(text, nullptr);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(*ParseNumber(text)),
              std::bit_cast<std::uint64_t>(expected))
        << text;
    const float narrow = std::strtof(text, nullptr);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(*ParseNumber<float>(text)),
              std::bit_cast<std::uint32_t>(narrow))
        << text;
  }
}

TEST(NumberText, ShortestComesBackBitForBit) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const auto number = std::bit_cast<double>(random());
    if (!std::isfinite(number)) continue;
    for (const auto append : {AppendShortest, AppendShortestFixed}) {
      std::string text;
      append(number, text);
      EXPECT_EQ(std::bit_cast<std::uint64_t>(*ParseFinite(text)),
                std::bit_cast<std::uint64_t>(number));
    }
  }
}

}  // namespace
}  // namespace intaglio::io
