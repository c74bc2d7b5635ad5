#include "engrave/mesh/weld_vertices.h"

#include <bit>
#include <limits>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::mesh {
namespace {

constexpr std::size_t kFirstSlotCount = 1024;

// Multiplication spreads the low bits upwards and the shift brings them back down:
// coordinates read from a float have 29 zero bits at the bottom of each double.
std::uint64_t Mix(std::uint64_t hash, double coordinate) {
  hash ^= std::bit_cast<std::uint64_t>(coordinate);
  hash *= 0x9E3779B97F4A7C15u;
  return hash ^ (hash >> 32);
}

std::uint64_t HashOf(const Vec3& p) { return Mix(Mix(Mix(0, p.x()), p.y()), p.z()); }

}  // namespace

VertexWelder::VertexWelder() : slots_(kFirstSlotCount, 0) {}

std::size_t VertexWelder::SlotOf(const Vec3& normalized) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = HashOf(normalized) & mask;
  while (slots_[slot] != 0 && points_[slots_[slot] - 1] != normalized) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

std::uint32_t VertexWelder::Add(const Vec3& point) {
  Require(point.allFinite(), "a vertex to merge must be finite, is ({}, {}, {})",
          point.x(), point.y(), point.z());
  // In round-to-nearest -0.0 + 0.0 is 0.0, and every other value stays as it is.
  const Vec3 normalized = point.array() + 0.0;
  const std::size_t slot = SlotOf(normalized);
  if (slots_[slot] != 0) return slots_[slot] - 1;
  Require(points_.size() < std::numeric_limits<std::uint32_t>::max() - 1,
          "more than 2^32 - 2 vertices");
  points_.push_back(normalized);
  const auto index = static_cast<std::uint32_t>(points_.size() - 1);
  slots_[slot] = index + 1;
  if (2 * points_.size() > slots_.size()) Grow();
  return index;
}

void VertexWelder::Grow() {
  slots_.assign(2 * slots_.size(), 0);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    slots_[SlotOf(points_[i])] = static_cast<std::uint32_t>(i + 1);
  }
}

PointList VertexWelder::TakePoints() {
  slots_.assign(kFirstSlotCount, 0);
  return std::exchange(points_, {});
}

}  // namespace intaglio::mesh
