#include "engrave/core/quick_random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace intaglio {
namespace {

// The first numbers of splitmix64 from 1234567, as its authors publish them: they are the
// state that a seed makes.
constexpr std::uint64_t kSeed = 1234567;
constexpr std::uint64_t kState[] = {6457827717110365317U, 3203168211198807973U,
                                    9817491932198370423U, 4593380528125082431U};

std::uint64_t TurnedLeft(std::uint64_t x, int by) { return (x << by) | (x >> (64 - by)); }

TEST(QuickRandom, IsXoshiro256PlusPlusSeededBySplitmix64) {
  QuickRandom random(kSeed);
  std::uint64_t s[4] = {kState[0], kState[1], kState[2], kState[3]};
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(random(), TurnedLeft(s[0] + s[3], 23) + s[0]) << i;
    const std::uint64_t t = s[1] << 17;
    s[2] = s[2] ^ s[0];
    s[3] = s[3] ^ s[1];
    s[1] = s[1] ^ s[2];
    s[0] = s[0] ^ s[3];
    s[2] = s[2] ^ t;
    s[3] = TurnedLeft(s[3], 45);
  }
  random.Seed(kSeed);
  EXPECT_EQ(random(), TurnedLeft(kState[0] + kState[3], 23) + kState[0]);
}

// Chi-squared of 256 equal cells has mean 255 and deviation 22.6: six of them are
// allowed.
TEST(QuickRandom, ItsHighBitsAreEvenForSeedsSideBySide) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    QuickRandom random(seed);
    std::vector<int> cells(256);
    constexpr int kDrawn = 256 * 400;
    for (int i = 0; i < kDrawn; ++i) ++cells[random() >> 56];
    double chi_squared = 0;
    for (const int count : cells) chi_squared += std::pow(count - 400.0, 2) / 400;
    EXPECT_NEAR(chi_squared, 255, 6 * 22.6) << seed;
  }
}

}  // namespace
}  // namespace intaglio
