#include "engrave/sort/layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engrave/sort/lowest_point.h"
#include "engrave/sort/remaining_points.h"

namespace intaglio::sort {
namespace {

constexpr double kMinThicknessMm = 0.01;
constexpr double kMaxThicknessMm = 100;

// Layers at multiples of the thickness lie on the slabs' limits, where rounding could put
// one layer in two slabs; so the limits are this share of the thickness lower.
constexpr double kLimitShare = 1e-6;

/// Slab number and index of each point, by slab.
std::vector<std::pair<std::uint64_t, std::uint32_t>> BySlab(const PointList& points_mm,
                                                            double lowest_mm,
                                                            double thickness_mm) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> slabs;
  slabs.reserve(points_mm.size());
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const double height = (points_mm[i].z() - lowest_mm) / thickness_mm;
    slabs.emplace_back(static_cast<std::uint64_t>(height + kLimitShare), i);
  }
  std::sort(slabs.begin(), slabs.end());
  return slabs;
}

}  // namespace

Status CheckLayersOptions(const OrderOptions& options) {
  const double thickness_mm = options.layers.layer_thickness_mm;
  if (thickness_mm >= kMinThicknessMm && thickness_mm <= kMaxThicknessMm) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("layers.layer_thickness_mm: {} is outside {}..{}", thickness_mm,
                          kMinThicknessMm, kMaxThicknessMm),
              fmt::format("{}", thickness_mm));
}

Result<Order> OrderByLayers(const PointList& points_mm, const OrderOptions& options,
                            const ProgressSink& progress) {
  Order order;
  order.reserve(points_mm.size());
  if (points_mm.empty()) return order;
  const Vec3& lowest_mm = points_mm[LowestPoint(points_mm)];
  RemainingPoints::Taken now{0, lowest_mm.x(), lowest_mm.y()};
  const auto slabs = BySlab(points_mm, lowest_mm.z(), options.layers.layer_thickness_mm);
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
  return order;
}

}  // namespace intaglio::sort
