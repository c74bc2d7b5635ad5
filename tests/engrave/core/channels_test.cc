#include "engrave/core/channels.h"

#include <gtest/gtest.h>

namespace intaglio {
namespace {

bool ShareOneOf(const std::vector<ChannelMask>& channels, ChannelMask a, ChannelMask b) {
  for (const ChannelMask c : channels) {
    if ((a & c) != 0 && (b & c) != 0) return true;
  }
  return false;
}

TEST(Channels, DistinctMasksAreEachThereOnce) {
  EXPECT_EQ(DistinctMasks(std::vector<ChannelMask>{3, 1, 3, 15, 1}),
            (std::vector<ChannelMask>{1, 3, 15}));
  EXPECT_TRUE(DistinctMasks({}).empty());
}

TEST(Channels, OneMaskIsThatOfAllPointsAndNotEmpty) {
  EXPECT_TRUE(HaveOneMask(std::vector<ChannelMask>{5, 5, 5}));
  EXPECT_FALSE(HaveOneMask(std::vector<ChannelMask>{5, 5, 1}));
  EXPECT_FALSE(HaveOneMask(std::vector<ChannelMask>{0, 0}));
  EXPECT_FALSE(HaveOneMask({}));
}

TEST(Channels, EqualMasksAreDistinguishedByOneChannel) {
  for (ChannelMask mask = 1; mask <= kAnyChannel; ++mask) {
    const auto deciding = DistinctChannels(std::vector<ChannelMask>{mask, mask});
    ASSERT_EQ(deciding.size(), 1u);
    EXPECT_TRUE(ShareChannel(deciding[0], mask));
  }
  EXPECT_TRUE(DistinctChannels({}).empty());
}

// Every set of masks that there is.
TEST(Channels, WhetherTwoShareOneIsDecidedOverAllMasks) {
  for (unsigned set = 0; set < 1U << kAnyChannel; ++set) {
    std::vector<ChannelMask> masks;
    for (unsigned i = 0; i < kAnyChannel; ++i) {
      if ((set >> i & 1) != 0) masks.push_back(static_cast<ChannelMask>(i + 1));
    }
    const auto deciding = DistinctChannels(masks);
    for (const ChannelMask a : masks) {
      for (const ChannelMask b : masks) {
        ASSERT_EQ(ShareOneOf(deciding, a, b), (a & b) != 0) << set;
      }
    }
  }
}

}  // namespace
}  // namespace intaglio
