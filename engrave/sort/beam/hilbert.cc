// The key by J. Skilling, Programming the Hilbert curve, AIP Conf. Proc. 707 (2004): undo
// the excess rotations from the highest bit down, Gray-encode, interleave the bits.

#include "engrave/sort/beam/hilbert.h"

#include <algorithm>
#include <array>

namespace intaglio::sort {
namespace {

constexpr int kBits = 11;
constexpr std::uint32_t kCells = 1U << kBits;

/// Two free bits between each of 11.
std::uint64_t Spread(std::uint64_t v) {
  v = (v | v << 16) & 0x0000FF0000FFULL;
  v = (v | v << 8) & 0x00F00F00F00FULL;
  v = (v | v << 4) & 0x0C30C30C30C3ULL;
  v = (v | v << 2) & 0x249249249249ULL;
  return v;
}

struct Keyed {
  std::uint64_t key;
  std::uint32_t index;
};

/// Stable, 11 bits at a time: three passes over 33-bit keys.
void RadixSort(std::vector<Keyed>& items) {
  std::vector<Keyed> other(items.size());
  for (int shift = 0; shift < 3 * kBits; shift += kBits) {
    std::array<std::size_t, kCells> place{};
    for (const Keyed& item : items) ++place[(item.key >> shift) % kCells];
    std::size_t next = 0;
    for (std::size_t& p : place) {
      const std::size_t count = p;
      p = next;
      next += count;
    }
    for (const Keyed& item : items) other[place[(item.key >> shift) % kCells]++] = item;
    items.swap(other);
  }
}

}  // namespace

std::uint64_t HilbertKey(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  // Without branches: which way a bit goes is as good as random.
  for (int bit = kBits - 1; bit > 0; --bit) {
    const std::uint32_t below = (1U << bit) - 1;
    const auto all_if_set = [bit](std::uint32_t v) { return 0U - (v >> bit & 1U); };
    x ^= below & all_if_set(x);
    // Invert x where the coordinate has the bit, exchange the lower bits where not.
    const auto unrotate = [&x, below, all_if_set](std::uint32_t& v) {
      const std::uint32_t inverted = all_if_set(v);
      const std::uint32_t exchanged = (x ^ v) & below & ~inverted;
      x ^= (below & inverted) | exchanged;
      v ^= exchanged;
    };
    unrotate(y);
    unrotate(z);
  }
  y ^= x;
  z ^= y;
  // Each bit: the parity of the bits of z above it.
  std::uint32_t flips = z >> 1;
  flips ^= flips >> 1;
  flips ^= flips >> 2;
  flips ^= flips >> 4;
  flips ^= flips >> 8;
  return Spread(x ^ flips) << 2 | Spread(y ^ flips) << 1 | Spread(z ^ flips);
}

std::vector<std::uint32_t> AlongHilbertCurve(const PointList& points_mm,
                                             std::span<const std::uint32_t> members,
                                             bool flat) {
  Box3 box;
  for (const std::uint32_t i : members) box.Extend(points_mm[i]);
  const double side_mm = box.size_mm().maxCoeff();
  // The scale of a single place does not matter.
  const double cells_per_mm = side_mm > 0 ? (kCells - 1) / side_mm : 0;
  std::vector<Keyed> items;
  items.reserve(members.size());
  for (const std::uint32_t i : members) {
    const Vec3 cell = (points_mm[i] - box.min_mm) * cells_per_mm;
    const auto coordinate = [](double v) {
      return std::min(static_cast<std::uint32_t>(v), kCells - 1);
    };
    items.push_back({HilbertKey(coordinate(cell.x()), coordinate(cell.y()),
                                flat ? 0 : coordinate(cell.z())),
                     i});
  }
  RadixSort(items);
  std::vector<std::uint32_t> sorted;
  sorted.reserve(items.size());
  for (const Keyed& item : items) sorted.push_back(item.index);
  return sorted;
}

}  // namespace intaglio::sort
