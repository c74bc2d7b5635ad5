#include "engrave/sort/order.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/sort/anneal.h"
#include "engrave/sort/beam/channel_groups.h"
#include "engrave/sort/boustrophedon.h"
#include "engrave/sort/jump_layers.h"
#include "engrave/sort/kdz.h"
#include "engrave/sort/layers.h"
#include "engrave/sort/published_kdz.h"
#include "engrave/sort/smooth.h"
#include "engrave/sort/sweep.h"

namespace intaglio::sort {
namespace {

struct MethodRow {
  Method method;
  Status (*check)(const OrderOptions&);
  Result<Order> (*make)(const PointList&, const OrderOptions&, const ProgressSink&);
};

// The registry: a new method is a line here.
constexpr std::array kMethods = {
    MethodRow{Method::kKdz, CheckKdzOptions, OrderByKdz},
    MethodRow{Method::kLayers, CheckLayersOptions, OrderByLayers},
    MethodRow{Method::kSmooth, CheckSmoothOptions, OrderSmoothly},
    MethodRow{Method::kAnneal, CheckAnnealOptions, OrderByAnnealing},
    MethodRow{Method::kSweep, CheckSweepOptions, OrderBySweep},
    MethodRow{Method::kBoustrophedon, CheckBoustrophedonOptions, OrderByBoustrophedon},
    MethodRow{Method::kJumpLayers, CheckJumpLayersOptions, OrderByJumpLayers},
    MethodRow{Method::kPublishedKdz, CheckPublishedKdzOptions, OrderByPublishedKdz},
};

const MethodRow& RowOf(Method method) {
  for (const MethodRow& row : kMethods) {
    if (row.method == method) return row;
  }
  throw PreconditionError(
      fmt::format("there is no order method {}", static_cast<int>(method)));
}

/// A kilometre: up to there coordinates are ten times finer than the surface of a beam
/// (BeamCone::kSurfaceMm), and ticks can be counted.
constexpr double kFarthestMm = 1e6;

Status CheckPoints(const PointList& points_mm) {
  constexpr std::size_t kMax = std::numeric_limits<std::uint32_t>::max();
  if (points_mm.size() > kMax) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("a cloud of {} points is larger than an order can be, {}",
                            points_mm.size(), kMax),
                std::to_string(points_mm.size()));
  }
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    const Vec3& p = points_mm[i];
    if (p.allFinite() && p.cwiseAbs().maxCoeff() <= kFarthestMm) continue;
    const char* const wrong = p.allFinite() ? "too far away" : "not finite";
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("point {} is {} and cannot be ordered", i, wrong),
                fmt::format("({}, {}, {})", p.x(), p.y(), p.z()));
  }
  return {};
}

}  // namespace

Result<Order> MakeOrder(const PointList& points_mm, const OrderOptions& options,
                        const ProgressSink& progress) {
  const MethodRow& row = RowOf(options.method);
  INTAGLIO_TRY(row.check(options));
  INTAGLIO_TRY(CheckPoints(points_mm));
  return row.make(points_mm, options, progress);
}

namespace {

/// Gives what belongs, of the time that all have and of their progress, to the points
/// from `begin` to `end` of `size`.
OrderOptions WithShareOfTime(OrderOptions options, double begin, double end,
                             double size) {
  const auto& used = options.anneal.used_share;
  if (!used) return options;
  options.anneal.used_share = [used, begin, end, size] {
    return std::clamp((used() * size - begin) / (end - begin), 0.0, 1.0);
  };
  return options;
}

ProgressSink PartOf(const ProgressSink& progress, std::uint64_t begin, std::uint64_t end,
                    std::uint64_t size) {
  if (!progress) return nullptr;
  return [=, &progress](std::uint64_t done, std::uint64_t total) {
    return progress(begin + (end - begin) * done / std::max<std::uint64_t>(total, 1),
                    size);
  };
}

}  // namespace

Result<Order> MakeChannelOrder(const PointList& points_mm,
                               std::span<const ChannelMask> masks,
                               const OrderOptions& options,
                               const ProgressSink& progress) {
  Require(masks.size() == points_mm.size() &&
              std::find(masks.begin(), masks.end(), 0) == masks.end(),
          "{} points have {} masks, or one without a channel", points_mm.size(),
          masks.size());
  if (DistinctMasks(masks).size() < 2) return MakeOrder(points_mm, options, progress);
  INTAGLIO_TRY(CheckPoints(points_mm));
  const auto groups = GroupByChannels(points_mm, masks, options.cone, progress);
  if (groups.empty()) return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  Order order;
  order.reserve(points_mm.size());
  for (const auto& group : groups) {
    PointList group_mm;
    for (const std::uint32_t index : group) group_mm.push_back(points_mm[index]);
    const std::size_t begin = order.size(), end = begin + group.size();
    const auto of_group = MakeOrder(
        group_mm,
        WithShareOfTime(options, static_cast<double>(begin), static_cast<double>(end),
                        static_cast<double>(points_mm.size())),
        PartOf(progress, begin, end, points_mm.size()));
    if (!of_group) return of_group;
    for (const std::uint32_t index : *of_group) order.push_back(group[index]);
  }
  return order;
}

}  // namespace intaglio::sort
