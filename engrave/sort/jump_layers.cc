#include "engrave/sort/jump_layers.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/beam/remaining_points.h"
#include "engrave/sort/cone_order.h"
#include "engrave/sort/way/jump_way.h"

namespace intaglio::sort {
namespace {

double RestToRestSeconds(double way_mm, const JumpTimes& times) {
  if (way_mm < times.z_mm_s * times.z_mm_s / times.z_mm_s2)
    return 2 * std::sqrt(way_mm / times.z_mm_s2);
  return way_mm / times.z_mm_s + times.z_mm_s / times.z_mm_s2;
}

/// Places of the mirrors, and the layer, a height of the axis z.
PointList HeadPlaces(const PointList& points_mm, const OrderOptions& options) {
  PointList places_mm;
  places_mm.reserve(points_mm.size());
  for (const Vec3& at : points_mm)
    places_mm.push_back(options.jump_layers.head_from_glass(at));
  return places_mm;
}

/// From the lowest up, in a layer in the order of lowest_point.h.
std::vector<std::uint32_t> ByHeight(const PointList& places_mm) {
  std::vector<std::uint32_t> all(places_mm.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  std::ranges::sort(all, [&](std::uint32_t a, std::uint32_t b) {
    return ComesFirst(places_mm[a], a, places_mm[b], b);
  });
  return all;
}

/// `members` from `from_mm` on, in a short way.
std::vector<std::uint32_t> ShortWay(const PointList& places_mm,
                                    std::span<const std::uint32_t> members,
                                    const Vec2& from_mm) {
  std::vector<Vec2> at_mm;
  std::vector<std::uint32_t> way;
  RemainingPoints remaining(places_mm, members, 0);
  RemainingPoints::Taken now{0, from_mm.x(), from_mm.y()};
  std::vector<std::uint32_t> nearest;
  for (std::uint32_t i = 0; i < members.size(); ++i) {
    now = remaining.TakeNearest(now.x_mm, now.y_mm);
    nearest.push_back(now.index);
    at_mm.emplace_back(places_mm[now.index].head<2>());
    way.push_back(i);
  }
  ShortenWay(at_mm, from_mm, way);
  for (std::uint32_t& point : way) point = nearest[point];
  return way;
}

/// Appends a layer so that no point of it is made through a crack of it.
void AppendLayer(const PointList& points_mm, std::span<const std::uint32_t> way,
                 const BeamCone& cone, Order& order) {
  PointList layer_mm;
  Order in_layer;
  for (std::uint32_t i = 0; i < way.size(); ++i) {
    layer_mm.push_back(points_mm[way[i]]);
    in_layer.push_back(i);
  }
  for (const std::uint32_t i : KeepToCone(layer_mm, in_layer, cone))
    order.push_back(way[i]);
}

}  // namespace

JumpTime TimeOfJumps(std::span<const Vec3> axes_mm, const JumpTimes& times) {
  JumpTime time;
  for (std::size_t i = 0; i < axes_mm.size(); ++i) {
    time.delay_s += times.jump_delay_s;
    time.dwell_s += times.dwell_s;
    if (i == 0) continue;
    const Vec3 step_mm = axes_mm[i] - axes_mm[i - 1];
    time.jump_s += step_mm.head<2>().norm() / times.jump_mm_s;
    if (step_mm.z() == 0) continue;
    ++time.z_move_count;
    time.z_s += RestToRestSeconds(std::abs(step_mm.z()), times) + times.z_settle_s;
  }
  return time;
}

Status CheckJumpLayersOptions(const OrderOptions& options) {
  if (options.jump_layers.head_from_glass) return {};
  return Fail(ErrorCode::kUnsupported,
              "ordering.jump_layers: is of machines whose head jumps to its points; this "
              "one has no head_over_block.jump_and_dwell: choose another order",
              "jump_layers");
}

Result<Order> OrderByJumpLayers(const PointList& points_mm, const OrderOptions& options,
                                const ProgressSink& progress) {
  Order order;
  order.reserve(points_mm.size());
  if (points_mm.empty()) return order;
  const PointList places_mm = HeadPlaces(points_mm, options);
  const std::vector<std::uint32_t> by_height = ByHeight(places_mm);
  Vec2 from_mm = places_mm[by_height.front()].head<2>();
  for (auto begin = by_height.begin(); begin != by_height.end();) {
    if (progress && !progress(order.size(), points_mm.size()))
      return Fail(ErrorCode::kCancelled, "the sort was cancelled");
    const double layer_mm = places_mm[*begin].z();
    const auto end = std::find_if(begin, by_height.end(), [&](std::uint32_t point) {
      return places_mm[point].z() != layer_mm;
    });
    AppendLayer(points_mm, ShortWay(places_mm, {begin, end}, from_mm), options.cone,
                order);
    from_mm = places_mm[order.back()].head<2>();
    begin = end;
  }
  if (options.cone.lean) return KeepToCone(points_mm, order, options.cone);
  return order;
}

}  // namespace intaglio::sort
