#include "services/console/plan_packer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "services/console/job_cloud.h"

namespace intaglio::console {
namespace {

constexpr int kCellShift = 13;  // of 16 bits; eight cells along each axis
constexpr std::size_t kPointBytes = 8;

std::uint16_t Share(double value, double whole) {
  const double ratio = whole > 0 ? std::clamp(value / whole, 0.0, 1.0) : 0.0;
  return static_cast<std::uint16_t>(std::lround(ratio * 65535));
}

using Packed = std::array<std::uint16_t, 4>;
static_assert(sizeof(Packed) == kPointBytes);

Packed PackPoint(const Vec3& point_mm, const Vec3& block_mm) {
  Packed packed{};
  for (int axis = 0; axis < 3; ++axis)
    packed[static_cast<std::size_t>(axis)] = Share(point_mm[axis], block_mm[axis]);
  return packed;
}

std::size_t CellOf(const Packed& point) {
  return static_cast<std::size_t>(point[0] >> kCellShift << 6 |
                                  point[1] >> kCellShift << 3 | point[2] >> kCellShift);
}

/// A little-endian host, as the readers of the formats.
template <typename Value>
void Write(std::string& bytes, std::size_t offset, const Value& value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

tl::unexpected<Error> OtherPoints() {
  return Fail(ErrorCode::kUnreadable,
              "the plan was written again while it was read; ask for it again");
}

}  // namespace

Result<PlanPacker> PlanPacker::Begin(std::uint64_t point_count, const Vec3& block_mm) {
  if (point_count >= std::uint64_t{1} << kOutcomeShift) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{} points are too many for a page, which draws less than "
                            "2^{}; thin them out",
                            point_count, kOutcomeShift));
  }
  PlanPacker packer;
  packer.point_count_ = static_cast<std::uint32_t>(point_count);
  packer.block_mm_ = block_mm;
  return packer;
}

void PlanPacker::Count(const PointList& points_mm) {
  for (const Vec3& point_mm : points_mm)
    ++starts_[CellOf(PackPoint(point_mm, block_mm_)) + 1];
}

void PlanPacker::Allocate() {
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  next_ = starts_;
  bytes_.resize(PackedPlanBytes(point_count_));
  std::memcpy(bytes_.data(), "INTPLAN2", 8);
  Write(bytes_, 8, point_count_);
  for (int axis = 0; axis < 3; ++axis) {
    Write(bytes_, 12 + 4 * static_cast<std::size_t>(axis),
          static_cast<float>(block_mm_[axis]));
  }
  std::memcpy(bytes_.data() + 24, starts_.data(), 4 * starts_.size());
}

Status PlanPacker::Place(const PointList& points_mm) {
  if (bytes_.empty()) Allocate();
  for (const Vec3& point_mm : points_mm) {
    Packed point = PackPoint(point_mm, block_mm_);
    const std::size_t cell = CellOf(point);
    if (next_[cell] == starts_[cell + 1] || next_[cell] >= point_count_)
      return OtherPoints();
    point[3] = Share(place_, point_count_);
    const std::size_t at = next_[cell]++;
    Write(bytes_, kPlanHeaderBytes + kPointBytes * at, point);
    Write(bytes_, kPlanHeaderBytes + kPointBytes * point_count_ + 4 * at, place_);
    ++place_;
  }
  return {};
}

void PlanPacker::Swap(std::uint32_t a, std::uint32_t b) {
  char* points = bytes_.data() + kPlanHeaderBytes;
  char* places = points + kPointBytes * point_count_;
  std::swap_ranges(points + kPointBytes * a, points + kPointBytes * (a + 1),
                   points + kPointBytes * b);
  std::swap_ranges(places + 4 * std::size_t{a}, places + 4 * (std::size_t{a} + 1),
                   places + 4 * std::size_t{b});
}

Result<std::string> PlanPacker::Finish() {
  if (bytes_.empty()) Allocate();
  if (place_ != point_count_ || starts_.back() != point_count_) return OtherPoints();
  // Fisher and Yates, with a fixed seed; std::shuffle differs between libraries. The
  // product's upper half is a number below the size with a bias below size/2^32.
  std::mt19937 random(1);
  for (std::size_t cell = 0; cell < kPlanCells; ++cell) {
    for (std::uint32_t size = starts_[cell + 1] - starts_[cell]; size > 1; --size) {
      const auto chosen =
          static_cast<std::uint32_t>(std::uint64_t{random()} * size >> 32);
      Swap(starts_[cell] + size - 1, starts_[cell] + chosen);
    }
  }
  return std::move(bytes_);
}

}  // namespace intaglio::console
