#include "engrave/sort/jump_layers.h"

#include <algorithm>
#include <cmath>
#include <map>
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

/// `members` from `from_mm` on, the nearest next.
std::vector<std::uint32_t> NearestNext(const PointList& places_mm,
                                       std::span<const std::uint32_t> members,
                                       const Vec2& from_mm) {
  RemainingPoints remaining(places_mm, members, 0);
  RemainingPoints::Taken now{0, from_mm.x(), from_mm.y()};
  std::vector<std::uint32_t> nearest;
  for (std::size_t i = 0; i < members.size(); ++i) {
    now = remaining.TakeNearest(now.x_mm, now.y_mm);
    nearest.push_back(now.index);
  }
  return nearest;
}

/// `way` so that no point of it is made through a crack of it.
std::vector<std::uint32_t> KeptToCone(const PointList& points_mm,
                                      std::span<const std::uint32_t> way,
                                      const BeamCone& cone) {
  PointList layer_mm;
  Order in_layer;
  for (std::uint32_t i = 0; i < way.size(); ++i) {
    layer_mm.push_back(points_mm[way[i]]);
    in_layer.push_back(i);
  }
  std::vector<std::uint32_t> kept;
  for (const std::uint32_t i : KeepToCone(layer_mm, in_layer, cone))
    kept.push_back(way[i]);
  return kept;
}

class LayerOrder {
 public:
  LayerOrder(const PointList& points_mm, const OrderOptions& options)
      : points_mm_(points_mm),
        places_mm_(HeadPlaces(points_mm, options)),
        options_(options) {
    if (!options.jump_layers.energy_from_glass) return;
    for (const Vec3& at : points_mm)
      energies_.push_back(options.jump_layers.energy_from_glass(at));
  }
  const PointList& places_mm() const { return places_mm_; }

  /// The way of least time through a layer, from `from_mm` on.
  std::vector<std::uint32_t> WayThrough(std::span<const std::uint32_t> members,
                                        const Vec2& from_mm) const {
    std::vector<std::uint32_t> best =
        Shortened(NearestNext(places_mm_, members, from_mm), from_mm);
    if (energies_.empty()) return best;
    std::map<std::uint32_t, std::vector<std::uint32_t>> groups;
    for (const std::uint32_t point : members) groups[energies_[point]].push_back(point);
    if (groups.size() == 1) return best;
    double min_s = Seconds(best, from_mm);
    const auto take = [&](auto begin, auto end) {
      std::vector<std::uint32_t> way = Shortened(Gathered(begin, end, from_mm), from_mm);
      const double seconds = Seconds(way, from_mm);
      if (seconds >= min_s) return;
      min_s = seconds;
      best = std::move(way);
    };
    take(groups.begin(), groups.end());
    take(groups.rbegin(), groups.rend());
    return best;
  }

 private:
  /// One group after the other.
  template <typename Groups>
  std::vector<std::uint32_t> Gathered(Groups begin, Groups end, Vec2 from_mm) const {
    std::vector<std::uint32_t> way;
    for (; begin != end; ++begin) {
      const auto of_group = NearestNext(places_mm_, begin->second, from_mm);
      way.insert(way.end(), of_group.begin(), of_group.end());
      from_mm = places_mm_[way.back()].head<2>();
    }
    return way;
  }
  /// With no point through a crack of the layer.
  std::vector<std::uint32_t> Shortened(std::span<const std::uint32_t> points,
                                       const Vec2& from_mm) const {
    std::vector<Vec2> at_mm;
    std::vector<std::uint32_t> way, energies;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      at_mm.emplace_back(places_mm_[points[i]].head<2>());
      way.push_back(i);
      if (!energies_.empty()) energies.push_back(energies_[points[i]]);
    }
    const JumpLayersOptions& jumps = options_.jump_layers;
    ShortenWay(at_mm, from_mm, way, {energies, jumps.change_s * jumps.jump_mm_s});
    for (std::uint32_t& point : way) point = points[point];
    return KeptToCone(points_mm_, way, options_.cone);
  }
  /// Of what the order decides.
  double Seconds(std::span<const std::uint32_t> way, Vec2 from_mm) const {
    double way_mm = 0;
    std::size_t changes = 0;
    for (std::size_t i = 0; i < way.size(); ++i) {
      const Vec2 to_mm = places_mm_[way[i]].head<2>();
      way_mm += (to_mm - from_mm).norm();
      from_mm = to_mm;
      changes += i > 0 && energies_[way[i]] != energies_[way[i - 1]];
    }
    return way_mm / options_.jump_layers.jump_mm_s +
           static_cast<double>(changes) * options_.jump_layers.change_s;
  }

  const PointList& points_mm_;
  PointList places_mm_;
  const OrderOptions& options_;
  std::vector<std::uint32_t> energies_;  ///< empty: all are alike
};

}  // namespace

JumpTime TimeOfJumps(std::span<const Vec3> axes_mm, const JumpTimes& times,
                     std::span<const std::uint32_t> energies) {
  JumpTime time;
  // None follows the last point.
  if (times.pause_after_points > 0 && !axes_mm.empty()) {
    time.pause_s = times.pause_s *
                   static_cast<double>((axes_mm.size() - 1) / times.pause_after_points);
  }
  std::uint32_t in_list = 0;
  for (std::size_t i = 0; i < axes_mm.size(); ++i) {
    time.delay_s += times.jump_delay_s;
    time.dwell_s += times.dwell_s;
    const Vec3 step_mm = i == 0 ? Vec3(Vec3::Zero()) : Vec3(axes_mm[i] - axes_mm[i - 1]);
    const bool changes = i > 0 && !energies.empty() && energies[i] != energies[i - 1];
    const bool is_full = times.max_list_points > 0 && in_list == times.max_list_points;
    if (i == 0 || step_mm.z() != 0 || changes || is_full) {
      ++time.list_count;
      in_list = 0;
    }
    ++in_list;
    if (i == 0) continue;
    if (step_mm.z() == 0 && changes) ++time.energy_change_count;
    time.jump_s += step_mm.head<2>().norm() / times.jump_mm_s;
    if (step_mm.z() == 0) continue;
    ++time.z_move_count;
    time.z_s += RestToRestSeconds(std::abs(step_mm.z()), times) + times.z_settle_s;
  }
  return time;
}

Status CheckJumpLayersOptions(const OrderOptions& options) {
  Require(options.jump_layers.jump_mm_s > 0 && options.jump_layers.change_s >= 0,
          "jumps at {} mm/s and {} s for a list", options.jump_layers.jump_mm_s,
          options.jump_layers.change_s);
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
  const LayerOrder layers(points_mm, options);
  const PointList& places_mm = layers.places_mm();
  const std::vector<std::uint32_t> by_height = ByHeight(places_mm);
  Vec2 from_mm = places_mm[by_height.front()].head<2>();
  for (auto begin = by_height.begin(); begin != by_height.end();) {
    if (progress && !progress(order.size(), points_mm.size()))
      return Fail(ErrorCode::kCancelled, "the sort was cancelled");
    const double layer_mm = places_mm[*begin].z();
    const auto end = std::find_if(begin, by_height.end(), [&](std::uint32_t point) {
      return places_mm[point].z() != layer_mm;
    });
    const auto way = layers.WayThrough({begin, end}, from_mm);
    order.insert(order.end(), way.begin(), way.end());
    from_mm = places_mm[order.back()].head<2>();
    begin = end;
  }
  if (options.cone.lean) return KeepToCone(points_mm, order, options.cone);
  return order;
}

}  // namespace intaglio::sort
