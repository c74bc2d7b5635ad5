#pragma once

// Packs the planned points of a job for pages. All numbers little endian.
//
// clang-format off
//        offset  size
//             0     8  "INTPLAN2"
//             8     4  points N
//            12    12  size of the block x, y, z, mm, floats
//            24  2052  place of the first point of each cell in this file; the last is N
//          2076   8 N  x, y, z of each point and its place in the order, in 1/65535 of the
//                      block's size and of N
//    2076 + 8 N   4 N  place of each point in the order
// clang-format on
//
// The block has 8 x 8 x 8 cells; that of a point has the upper three bits of its numbers:
// x/8192 * 64 + y/8192 * 8 + z/8192. Inside a cell the points are in a random order, the
// same each time: every first part of a cell is a fair sample of it. So whoever draws a
// share of what is in view takes this share of the points of each cell.

#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::console {

inline constexpr std::uint32_t kPlanCells = 512;
inline constexpr std::size_t kPlanHeaderBytes = 24 + 4 * (kPlanCells + 1);

/// Bytes of a packed plan.
constexpr std::size_t PackedPlanBytes(std::uint64_t point_count) {
  return kPlanHeaderBytes + 12 * point_count;
}

/// Takes the points twice, piece by piece in their order: to count them, and to place
/// them. So nothing but the packed plan is in memory.
class PlanPacker {
 public:
  /// `block_mm`: glass frame. At most 2^29 points, else kTooLarge.
  static Result<PlanPacker> Begin(std::uint64_t point_count, const Vec3& block_mm);

  void Count(const PointList& points_mm);
  /// kUnreadable: these are other points than those that were counted.
  Status Place(const PointList& points_mm);
  /// Once; kUnreadable: as Place().
  Result<std::string> Finish();

 private:
  PlanPacker() = default;
  void Allocate();
  void Swap(std::uint32_t a, std::uint32_t b);

  std::uint32_t point_count_ = 0, place_ = 0;
  Vec3 block_mm_;
  std::vector<std::uint32_t> starts_ = std::vector<std::uint32_t>(kPlanCells + 1);
  std::vector<std::uint32_t> next_;  // of each cell, while points are placed
  std::string bytes_;
};

}  // namespace intaglio::console
