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

TEST(Channels, EqualMasksAreToldByOneChannel) {
  for (ChannelMask mask = 1; mask <= kAnyChannel; ++mask) {
    const auto telling = TellingChannels(std::vector<ChannelMask>{mask, mask});
    ASSERT_EQ(telling.size(), 1u);
    EXPECT_TRUE(ShareChannel(telling[0], mask));
  }
  EXPECT_TRUE(TellingChannels({}).empty());
}

// Every set of masks that there is.
TEST(Channels, TheyTellOfAllMasksWhetherTwoShareOne) {
  for (unsigned set = 0; set < 1U << kAnyChannel; ++set) {
    std::vector<ChannelMask> masks;
    for (unsigned i = 0; i < kAnyChannel; ++i) {
      if ((set >> i & 1) != 0) masks.push_back(static_cast<ChannelMask>(i + 1));
    }
    const auto telling = TellingChannels(masks);
    for (const ChannelMask a : masks) {
      for (const ChannelMask b : masks) {
        ASSERT_EQ(ShareOneOf(telling, a, b), (a & b) != 0) << set;
      }
    }
  }
}

}  // namespace
}  // namespace intaglio
