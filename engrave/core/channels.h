#pragma once

// The machine splits its beam into up to four channels, each with a block of its own. A
// point is made in the channels of its mask; points without a common channel are in
// different blocks and do not affect each other.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio {

using ChannelMask = std::uint8_t;  ///< bit 0..3: channels 1..4

inline constexpr int kMaxChannels = 4;
inline constexpr ChannelMask kAnyChannel = 0x0f;

/// Of one channel, by its number, 1..4.
constexpr ChannelMask MaskOfChannel(std::uint32_t number) {
  return static_cast<ChannelMask>(1U << (number - 1));
}

inline bool ShareChannel(ChannelMask a, ChannelMask b) { return (a & b) != 0; }

/// The masks that occur, each once, rising.
std::vector<ChannelMask> DistinctMasks(std::span<const ChannelMask> masks);

/// All points are made in the same channels, and in one at least: each may affect each.
bool HaveOneMask(std::span<const ChannelMask> masks);

/// Single channels, as few as are needed so that any two of `masks` that share a channel
/// share one of these. One when all masks are equal.
std::vector<ChannelMask> DistinctChannels(std::span<const ChannelMask> masks);

/// The points that are made in any of `channels`, in their order; `masks`: one a point.
PointCloud PointsIn(ChannelMask channels, const PointCloud& cloud,
                    std::span<const ChannelMask> masks);

}  // namespace intaglio
