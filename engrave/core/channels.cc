#include "engrave/core/channels.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace intaglio {

std::vector<ChannelMask> DistinctMasks(std::span<const ChannelMask> masks) {
  std::array<bool, 256> occurs{};
  for (const ChannelMask mask : masks) occurs[mask] = true;
  std::vector<ChannelMask> distinct;
  for (std::size_t mask = 0; mask < occurs.size(); ++mask) {
    if (occurs[mask]) distinct.push_back(static_cast<ChannelMask>(mask));
  }
  return distinct;
}

// A channel adds no information if another channel occurs in all masks that contain it.
bool HaveOneMask(std::span<const ChannelMask> masks) {
  return DistinctMasks(masks).size() == 1 && masks.front() != 0;
}

std::vector<ChannelMask> DistinctChannels(std::span<const ChannelMask> masks) {
  const std::vector<ChannelMask> distinct = DistinctMasks(masks);
  const auto implies = [&distinct](ChannelMask a, ChannelMask b) {
    return std::all_of(distinct.begin(), distinct.end(), [a, b](ChannelMask mask) {
      return !ShareChannel(mask, a) || ShareChannel(mask, b);
    });
  };
  std::vector<ChannelMask> deciding;
  for (int i = 0; i < kMaxChannels; ++i) {
    const auto channel = static_cast<ChannelMask>(1 << i);
    bool reported = implies(channel, 0);  // by no mask at all
    for (int j = 0; j < kMaxChannels && !reported; ++j) {
      const auto other = static_cast<ChannelMask>(1 << j);
      reported = j != i && implies(channel, other) && (j < i || !implies(other, channel));
    }
    if (!reported) deciding.push_back(channel);
  }
  return deciding;
}

PointCloud PointsIn(ChannelMask channels, const PointCloud& cloud,
                    std::span<const ChannelMask> masks) {
  PointCloud in_channels;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!ShareChannel(masks[i], channels)) continue;
    in_channels.Add(cloud.points_mm[i], cloud.source[i]);
  }
  return in_channels;
}

}  // namespace intaglio
