#include "engrave/sort/smooth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "engrave/core/shared_progress.h"
#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/beam/remaining_points.h"
#include "engrave/sort/kdz.h"
#include "engrave/sort/near/tick_cost.h"
#include "engrave/sort/planned_ticks.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kCandidates = 12;
constexpr std::size_t kPointsPerReport = 1 << 14;
constexpr double kMinRateHz = 1;
constexpr double kMaxRateHz = 50000;

/// In ticks: of a bend at the limit, and of a millimetre aside or up.
struct Weights {
  float bend;
  double way_per_mm;
  double lift_per_mm;
};

/// Median distance (largest axis) of a few points to the nearest other one, mm.
double TypicalSpacing(const PointList& points_mm) {
  constexpr std::size_t kSamples = 63;
  std::vector<double> nearest;
  const std::size_t stride = points_mm.size() / kSamples + 1;
  for (std::size_t i = stride / 2; i < points_mm.size(); i += stride) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < points_mm.size(); ++k) {
      const double d = (points_mm[k] - points_mm[i]).cwiseAbs().maxCoeff();
      if (d > 0) smallest = std::min(smallest, d);
    }
    nearest.push_back(smallest);
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return *middle;
}

/// The weights worth trying, by experiment. A point left behind or below costs a move of
/// its own later, from rest to rest at worst: with weights that high contours are
/// followed without a gap. Lower ones suit clouds without rows.
std::vector<Weights> WeightsToTry(const TickCost& cost, const PointList& points_mm) {
  const double spacing_mm = TypicalSpacing(points_mm);
  if (!std::isfinite(spacing_mm)) return {{1, 0, 0}};
  const double detour = cost.StopAndGoTicks(spacing_mm) / spacing_mm;
  return {{0.5F, detour, 2 * detour},
          {0.5F, detour / 5, detour / 5},
          {0.5F, 0, 2.5 * detour}};
}

class Walk {
 public:
  Walk(const PointList& points_mm, const OrderOptions& options, const Weights& weights)
      : points_mm_(points_mm),
        cone_(options.cone),
        weights_(weights),
        cost_(options.limits, options.rate_hz),
        all_(points_mm.size()),
        remaining_((std::iota(all_.begin(), all_.end(), 0U), points_mm), all_,
                   DefaultUpRatio(options.cone)) {}

  /// Empty when `progress` requested cancellation.
  Order Make(SharedProgress& progress) {
    Order order;
    order.reserve(points_mm_.size());
    now_mm_ = points_mm_[LowestPoint(points_mm_)];
    while (remaining_.size() > 0) {
      if (order.size() % kPointsPerReport == 0 &&
          !progress.GoesOn(order.empty() ? 0 : kPointsPerReport)) {
        return {};
      }
      remaining_.FindNearest(now_mm_.x(), now_mm_.y(), kCandidates, found_);
      const RemainingPoints::Candidate& next = found_[Choose()];
      const Scaled step = cost_.Scale(next.position_mm - now_mm_);
      // The first of all is made at rest.
      if (!order.empty()) before_ = {step, cost_.TicksAfter(before_, step)};
      now_mm_ = next.position_mm;
      order.push_back(next.index);
      remaining_.Take(next);
    }
    return order;
  }

 private:
  std::size_t Choose() {
    scores_.clear();
    for (const RemainingPoints::Candidate& candidate : found_) {
      scores_.push_back(ScoreOf(candidate.position_mm - now_mm_));
    }
    for (;;) {
      const auto best = static_cast<std::size_t>(
          std::min_element(scores_.begin(), scores_.end()) - scores_.begin());
      if (best == 0 || !remaining_.Shades(found_[best].position_mm, cone_)) return best;
      scores_[best] = std::numeric_limits<double>::infinity();
    }
  }

  double ScoreOf(const Vec3& step_mm) const {
    const Scaled step = cost_.Scale(step_mm);
    const float ticks = cost_.TicksAfter(before_, step);
    const float bend = TickCost::Bend(before_, {step, ticks});
    return ticks + weights_.bend * bend * bend +
           weights_.way_per_mm * step_mm.cwiseAbs().maxCoeff() +
           weights_.lift_per_mm * step_mm.z();
  }

  const PointList& points_mm_;
  BeamCone cone_;
  Weights weights_;
  TickCost cost_;
  Order all_;
  RemainingPoints remaining_;
  Vec3 now_mm_ = Vec3::Zero();
  TimedMove before_;
  std::vector<RemainingPoints::Candidate> found_;
  std::vector<double> scores_;
};

}  // namespace

Status CheckSmoothOptions(const OrderOptions& options) {
  const double rate_hz = options.rate_hz;
  if (rate_hz >= kMinRateHz && rate_hz <= kMaxRateHz) return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("rate_hz: {} is outside {}..{}", rate_hz, kMinRateHz, kMaxRateHz),
      fmt::format("{}", rate_hz));
}

Result<Order> OrderSmoothly(const PointList& points_mm, const OrderOptions& options,
                            const ProgressSink& progress) {
  if (points_mm.empty()) return Order{};
  const TickCost cost(options.limits, options.rate_hz);
  const std::vector<Weights> trials = WeightsToTry(cost, points_mm);
  std::vector<Order> orders(trials.size());
  std::vector<std::uint64_t> ticks(trials.size());
  // All trials together make one order: their progress is reported in its points.
  const ProgressSink of_one =
      progress
          ? [&](std::uint64_t done,
                std::
                    uint64_t) { return progress(done / trials.size(), points_mm.size()); }
          : ProgressSink();
  SharedProgress trial_progress(of_one, trials.size() * points_mm.size());
  const auto make_trial = [&](std::size_t i) {
    if (trial_progress.cancelled()) return;
    orders[i] = Walk(points_mm, options, trials[i]).Make(trial_progress);
    ticks[i] = PlannedTicks(points_mm, orders[i], options.limits, options.rate_hz);
  };
  // The first is as good as can be for many clouds; then no other is tried.
  make_trial(0);
  if (!trial_progress.cancelled() && IsNearTheBound(ticks[0], points_mm.size())) {
    return std::move(orders[0]);
  }
  RunEach(options.executor, trials.size() - 1, [&](std::size_t i) { make_trial(i + 1); });
  if (trial_progress.cancelled()) {
    return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  }
  const auto best = std::min_element(ticks.begin(), ticks.end()) - ticks.begin();
  return std::move(orders[static_cast<std::size_t>(best)]);
}

}  // namespace intaglio::sort
