#include "services/synchronizer/permission_chain.h"

#include <gtest/gtest.h>

namespace intaglio::synchronizer {
namespace {

constexpr int kLinkCount = 12;

ChainLinks LinksOfBits(unsigned bits) {
  const auto bit = [bits](int i) { return (bits >> i & 1u) != 0; };
  return {bit(0), bit(1), bit(2), bit(3), bit(4),  bit(5),
          bit(6), bit(7), bit(8), bit(9), bit(10), bit(11)};
}

TEST(PermissionChain, OnlyTheWholeChainAllowsAPulse) {
  for (unsigned bits = 0; bits < 1u << kLinkCount; ++bits) {
    const bool whole = bits == (1u << kLinkCount) - 1;
    EXPECT_EQ(FirstMissing(LinksOfBits(bits), true) == Missing::kNothing, whole) << bits;
    const bool whole_but_shutters = (bits | 1u << 11) == (1u << kLinkCount) - 1;
    EXPECT_EQ(FirstMissing(LinksOfBits(bits), false) == Missing::kNothing,
              whole_but_shutters)
        << bits;
  }
}

TEST(PermissionChain, EveryMissingLinkSaysWhatToDo) {
  for (int i = 0; i < kLinkCount; ++i) {
    const unsigned all_but_one = ((1u << kLinkCount) - 1) & ~(1u << i);
    const Missing missing = FirstMissing(LinksOfBits(all_but_one), true);
    EXPECT_NE(missing, Missing::kNothing) << i;
    EXPECT_FALSE(TextOf(missing).empty()) << i;
  }
  EXPECT_TRUE(TextOf(Missing::kNothing).empty());
}

TEST(PermissionChain, DefaultIsOff) {
  EXPECT_NE(FirstMissing(ChainLinks{}, false), Missing::kNothing);
}

}  // namespace
}  // namespace intaglio::synchronizer
