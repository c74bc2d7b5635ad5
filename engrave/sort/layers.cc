#include "engrave/sort/layers.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/beam/remaining_points.h"
#include "engrave/sort/cone_order.h"
#include "engrave/sort/slabs.h"

namespace intaglio::sort {
namespace {

/// Slab number and index of each point, by slab.
std::vector<std::pair<std::uint64_t, std::uint32_t>> BySlab(const PointList& points_mm,
                                                            double thickness_mm) {
  const std::vector<std::uint64_t> numbers = SlabNumbers(points_mm, 2, thickness_mm);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> slabs;
  slabs.reserve(points_mm.size());
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) slabs.emplace_back(numbers[i], i);
  std::sort(slabs.begin(), slabs.end());
  return slabs;
}

}  // namespace

Status CheckLayersOptions(const OrderOptions& options) {
  return CheckThickness("layers.layer_thickness_mm", options.layers.layer_thickness_mm);
}

Result<Order> OrderByLayers(const PointList& points_mm, const OrderOptions& options,
                            const ProgressSink& progress) {
  Order order;
  order.reserve(points_mm.size());
  if (points_mm.empty()) return order;
  const Vec3& lowest_mm = points_mm[LowestPoint(points_mm)];
  RemainingPoints::Taken now{0, lowest_mm.x(), lowest_mm.y()};
  const auto slabs = BySlab(points_mm, options.layers.layer_thickness_mm);
  std::vector<std::uint32_t> members;
  for (auto begin = slabs.begin(); begin != slabs.end();) {
    if (progress && !progress(order.size(), points_mm.size())) {
      return Fail(ErrorCode::kCancelled, "the sort was cancelled");
    }
    members.clear();
    const std::uint64_t slab = begin->first;
    for (; begin != slabs.end() && begin->first == slab; ++begin) {
      members.push_back(begin->second);
    }
    RemainingPoints remaining(points_mm, members, 0);
    for (std::size_t i = 0; i < members.size(); ++i) {
      now = remaining.TakeNearest(now.x_mm, now.y_mm);
      order.push_back(now.index);
    }
  }
  return KeepToCone(points_mm, order, options.cone);
}

}  // namespace intaglio::sort
