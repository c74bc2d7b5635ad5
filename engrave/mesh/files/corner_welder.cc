#include "engrave/mesh/files/corner_welder.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::mesh {
namespace {

constexpr std::size_t kFewestSlots = 1024;
// Corners between the prefetch of a slot and its use: a cache line takes 100 to 200 ns to
// load, a corner that does not wait about 8.
constexpr std::size_t kAhead = 24;
// Table full to 7/10: a corner that is found reads 2.2 slots on average, one that is not
// found reads 6, nearly all in the cache line that is already loaded.
constexpr std::size_t SlotCountFor(std::size_t corner_count) {
  return std::bit_ceil(std::max(kFewestSlots, corner_count / 7 * 10));
}
constexpr bool IsTooFull(std::size_t corner_count, std::size_t slot_count) {
  return corner_count > slot_count / 10 * 7;
}

std::uint64_t Bits(float coordinate) { return std::bit_cast<std::uint32_t>(coordinate); }

// The high bits of a product depend on all bits of its factors; they choose the slot.
std::uint64_t HashOf(const CornerWelder::Corner& c) {
  std::uint64_t hash = (Bits(c[0]) | Bits(c[1]) << 32) * 0x9E3779B97F4A7C15u;
  hash = (hash ^ (hash >> 29) ^ Bits(c[2])) * 0xBF58476D1CE4E5B9u;
  return (hash ^ (hash >> 32)) * 0x94D049BB133111EBu;
}

}  // namespace

CornerWelder::CornerWelder(std::size_t expected_count)
    : slots_(SlotCountFor(expected_count)),
      shift_(64u - static_cast<unsigned>(std::countr_zero(slots_.size()))) {
  points_.reserve(expected_count);
}

std::size_t CornerWelder::SlotOf(const Corner& corner) const {
  return HashOf(corner) >> shift_;
}

std::uint32_t CornerWelder::Find(const Corner& corner, std::size_t slot) {
  const std::size_t mask = slots_.size() - 1;
  while (slots_[slot].index_plus_1 != 0) {
    if (slots_[slot].corner == corner) return slots_[slot].index_plus_1 - 1;
    slot = (slot + 1) & mask;
  }
  Require(points_.size() < std::numeric_limits<std::uint32_t>::max() - 1,
          "more than 2^32 - 2 vertices");
  points_.emplace_back(corner[0], corner[1], corner[2]);
  const auto index_plus_1 = static_cast<std::uint32_t>(points_.size());
  slots_[slot] = {corner, index_plus_1};
  return index_plus_1 - 1;
}

void CornerWelder::Add(std::span<const Corner> corners,
                       std::span<std::uint32_t> indices) {
  Require(indices.size() == corners.size(), "{} indices for {} corners", indices.size(),
          corners.size());
  std::array<Corner, kAhead> pending;
  std::array<std::size_t, kAhead> slots;
  while (!corners.empty()) {
    // Between two batches only: growth moves the slots that were prefetched.
    const std::size_t batch = std::min<std::size_t>(corners.size(), 4096);
    while (IsTooFull(points_.size() + batch, slots_.size())) Grow();
    const auto ask = [&](std::size_t i) {
      Corner& corner = pending[i % kAhead];
      // In round-to-nearest -0.0 + 0.0 is 0.0, and every other value stays as it is.
      for (int axis = 0; axis < 3; ++axis) corner[axis] = corners[i][axis] + 0.0f;
      slots[i % kAhead] = SlotOf(corner);
      __builtin_prefetch(&slots_[slots[i % kAhead]]);
    };
    const std::size_t ahead = std::min(kAhead, batch);
    for (std::size_t i = 0; i < ahead; ++i) ask(i);
    for (std::size_t i = 0; i < batch; ++i) {
      indices[i] = Find(pending[i % kAhead], slots[i % kAhead]);
      if (i + kAhead < batch) ask(i + kAhead);
    }
    corners = corners.subspan(batch);
    indices = indices.subspan(batch);
  }
}

void CornerWelder::Grow() {
  const std::vector<Slot> old =
      std::exchange(slots_, std::vector<Slot>(2 * slots_.size()));
  --shift_;
  const std::size_t mask = slots_.size() - 1;
  for (const Slot& taken : old) {
    if (taken.index_plus_1 == 0) continue;
    std::size_t slot = SlotOf(taken.corner);
    while (slots_[slot].index_plus_1 != 0) slot = (slot + 1) & mask;
    slots_[slot] = taken;
  }
}

PointList CornerWelder::TakePoints() {
  slots_.assign(kFewestSlots, {});
  shift_ = 64u - static_cast<unsigned>(std::countr_zero(kFewestSlots));
  return std::exchange(points_, {});
}

}  // namespace intaglio::mesh
