#include "engrave/sort/sweep_begin.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/beam/remaining_points.h"
#include "engrave/sort/slabs.h"

// Moore's curve is a closed Hilbert curve: four of them, up the left half of a square and
// down its right half. A point at the place s of the curve, 0 <= s < 1 by the number of
// points before it, and at the height z belongs to the round m that makes the axis,
//   z_axis = pitch (m + s),
// the nearest to it: |z - z_axis| <= pitch / 2.

namespace intaglio::sort {
namespace {

/// Continues from `at_mm` to the nearest point of the slab, again and again.
void AppendNearest(const PointList& points_mm, std::span<const std::uint32_t> slab,
                   Vec2& at_mm, Order& order) {
  PointList slab_mm;
  slab_mm.reserve(slab.size());
  for (const std::uint32_t point : slab) slab_mm.push_back(points_mm[point]);
  Order members(slab.size());
  std::iota(members.begin(), members.end(), 0U);
  RemainingPoints remaining(slab_mm, members, 0);
  while (remaining.size() > 0) {
    const auto taken = remaining.TakeNearest(at_mm.x(), at_mm.y());
    order.push_back(slab[taken.index]);
    at_mm = {taken.x_mm, taken.y_mm};
  }
}

/// Longer pieces are annealed by themselves, for the sake of the cache.
void AppendPieces(std::size_t begin, std::size_t end, std::vector<std::size_t>& ends) {
  constexpr std::size_t kLongest = 8192;
  for (; begin < end; begin = ends.back()) {
    ends.push_back(std::min(begin + kLongest, end));
  }
}

constexpr std::uint32_t kCurveBits = 10;

/// The place of a cell on Hilbert's curve from (0, 0) to (side - 1, 0) of a square;
/// `side` is a power of two.
std::uint64_t AlongHilbert(std::uint32_t x, std::uint32_t y, std::uint32_t side) {
  std::uint64_t along = 0;
  for (std::uint32_t half = side / 2; half > 0; half /= 2) {
    const std::uint32_t right = (x & half) != 0 ? 1 : 0, upper = (y & half) != 0 ? 1 : 0;
    along += static_cast<std::uint64_t>(half) * half * ((3 * right) ^ upper);
    if (upper == 0) {
      if (right == 1) {
        x = side - 1 - x;
        y = side - 1 - y;
      }
      std::swap(x, y);
    }
  }
  return along;
}

std::uint64_t AlongMoore(std::uint32_t x, std::uint32_t y) {
  constexpr std::uint32_t kHalf = 1U << (kCurveBits - 1);
  constexpr std::uint64_t kQuarter = static_cast<std::uint64_t>(kHalf) * kHalf;
  const bool right = x >= kHalf, upper = y >= kHalf;
  const std::uint32_t in_x = x % kHalf, in_y = y % kHalf;
  if (!right) {
    return (upper ? 1 : 0) * kQuarter + AlongHilbert(in_y, kHalf - 1 - in_x, kHalf);
  }
  return (upper ? 2 : 3) * kQuarter + AlongHilbert(kHalf - 1 - in_y, in_x, kHalf);
}

/// The share of the points that are before each on the curve.
std::vector<double> SharesOfCurve(const PointList& points_mm) {
  Box3 box;
  for (const Vec3& point : points_mm) box.Extend(point);
  constexpr std::uint32_t kCells = 1U << kCurveBits;
  const Vec2 cells_per_mm =
      (kCells - 1) * box.size_mm().head<2>().cwiseMax(1e-9).cwiseInverse();
  std::vector<std::pair<std::uint64_t, std::uint32_t>> along;
  along.reserve(points_mm.size());
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const Vec2 cell = (points_mm[i] - box.min_mm).head<2>().cwiseProduct(cells_per_mm);
    along.emplace_back(AlongMoore(static_cast<std::uint32_t>(cell.x()),
                                  static_cast<std::uint32_t>(cell.y())),
                       i);
  }
  std::ranges::sort(along);
  std::vector<double> shares(points_mm.size());
  for (std::size_t rank = 0; rank < along.size(); ++rank) {
    shares[along[rank].second] =
        static_cast<double>(rank) / static_cast<double>(along.size());
  }
  return shares;
}

}  // namespace

SweptOrder BeginInSlabs(const PointList& lifted_mm, double slab_mm) {
  const std::vector<std::uint64_t> numbers = SlabNumbers(lifted_mm, 2, slab_mm);
  Order by_slab(lifted_mm.size());
  std::iota(by_slab.begin(), by_slab.end(), 0U);
  std::ranges::sort(by_slab, {},
                    [&](std::uint32_t i) { return std::pair(numbers[i], i); });
  SweptOrder begun;
  begun.order.reserve(lifted_mm.size());
  Vec2 at_mm = lifted_mm[LowestPoint(lifted_mm)].head<2>();
  for (std::size_t begin = 0; begin < by_slab.size();) {
    std::size_t end = begin + 1;
    while (end < by_slab.size() && numbers[by_slab[end]] == numbers[by_slab[begin]]) {
      ++end;
    }
    AppendNearest(lifted_mm, std::span(by_slab).subspan(begin, end - begin), at_mm,
                  begun.order);
    AppendPieces(begin, end, begun.ends);
    begin = end;
  }
  return begun;
}

SweptOrder BeginInRounds(const PointList& lifted_mm, double pitch_mm) {
  const std::vector<double> shares = SharesOfCurve(lifted_mm);
  std::vector<std::pair<double, std::uint32_t>> rounds;
  rounds.reserve(lifted_mm.size());
  for (std::uint32_t i = 0; i < lifted_mm.size(); ++i) {
    const double share = shares[i];
    rounds.emplace_back(std::round(lifted_mm[i].z() / pitch_mm - share) + share, i);
  }
  std::ranges::sort(rounds);
  SweptOrder begun;
  for (const auto& [round, point] : rounds) {
    begun.order.push_back(point);
    begun.axis_mm.push_back(pitch_mm * round);
  }
  AppendPieces(0, begun.order.size(), begun.ends);
  return begun;
}

}  // namespace intaglio::sort
