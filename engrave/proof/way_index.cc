#include "engrave/proof/way_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace intaglio::proof {
namespace {

constexpr double kBucket_mm = 1;
constexpr double kPart_mm = 0.5;  // a long step is in the buckets along it

std::int64_t BucketNumber(double mm) {
  return static_cast<std::int64_t>(std::floor(mm / kBucket_mm));
}
std::uint64_t BucketKey(std::int64_t x, std::int64_t y) {
  return static_cast<std::uint64_t>(x) << 32 ^
         (static_cast<std::uint64_t>(y) & 0xffffffffU);
}

}  // namespace

Vec2 ToStep(const Vec2& place_mm, const CutStep& step) {
  const Vec2 from = step.from_mm.head<2>(), way = step.to_mm.head<2>() - from;
  const double square = way.squaredNorm();
  const double along =
      square > 0 ? std::clamp((place_mm - from).dot(way) / square, 0.0, 1.0) : 0;
  return from + along * way - place_mm;
}

WayIndex::WayIndex(std::span<const CutStep> steps) : steps_(steps) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Vec2 from = steps[i].from_mm.head<2>(), way = steps[i].to_mm.head<2>() - from;
    const int parts = std::max(1, static_cast<int>(std::ceil(way.norm() / kPart_mm)));
    for (int part = 0; part <= parts; ++part) {
      const Vec2 at = from + way * part / parts;
      auto& bucket = buckets_[BucketKey(BucketNumber(at.x()), BucketNumber(at.y()))];
      const auto number = static_cast<std::uint32_t>(i);
      if (bucket.empty() || bucket.back() != number) bucket.push_back(number);
    }
  }
}

std::vector<std::uint32_t> WayIndex::StepsNear(const Vec2& place_mm, const Depths& depths,
                                               double near_mm) const {
  std::vector<std::uint32_t> near;
  const std::int64_t x = BucketNumber(place_mm.x()), y = BucketNumber(place_mm.y());
  for (std::int64_t dx = -1; dx <= 1; ++dx) {
    for (std::int64_t dy = -1; dy <= 1; ++dy) {
      const auto bucket = buckets_.find(BucketKey(x + dx, y + dy));
      if (bucket == buckets_.end()) continue;
      for (const std::uint32_t number : bucket->second) {
        const CutStep& step = steps_[number];
        const auto [low, high] = std::minmax(step.from_mm.z(), step.to_mm.z());
        if (low > -depths.min_mm || high < -depths.max_mm) continue;
        if (ToStep(place_mm, step).norm() <= near_mm) near.push_back(number);
      }
    }
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  return near;
}

std::size_t WayIndex::VisitsOf(const Vec2& place_mm, double depth_mm,
                               double near_mm) const {
  const auto near =
      StepsNear(place_mm, {depth_mm - near_mm, depth_mm + near_mm}, near_mm);
  std::size_t visits = 0;
  for (std::size_t i = 0; i < near.size(); ++i)
    visits += i == 0 || near[i] != near[i - 1] + 1;
  return visits;
}

std::optional<Vec2> WayIndex::ToNearest(const Vec2& place_mm, double depth_mm,
                                        double near_mm) const {
  std::optional<Vec2> nearest;
  for (const std::uint32_t number :
       StepsNear(place_mm, {depth_mm - near_mm, depth_mm + near_mm}, near_mm)) {
    const Vec2 to = ToStep(place_mm, steps_[number]);
    if (!nearest || to.norm() < nearest->norm()) nearest = to;
  }
  return nearest;
}

bool WayIndex::ReachesTo(const Vec2& place_mm, double depth_mm, double near_mm) const {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  return !StepsNear(place_mm, {depth_mm - near_mm, kInfinite}, near_mm).empty();
}

}  // namespace intaglio::proof
