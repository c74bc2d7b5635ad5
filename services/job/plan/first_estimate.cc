#include "services/job/plan/first_estimate.h"

#include <cmath>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/motion/planner.h"
#include "engrave/motion/point_plan.h"
#include "engrave/motion/segments/segment.h"
#include "engrave/sort/local_samples.h"
#include "services/job/convert/options.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/plan/steady_ticks.h"

namespace intaglio {
namespace {

class Estimator {
 public:
  Estimator(const FrozenJob& job, const Executor& executor, const ProgressSink& progress,
            const EstimateOptions& options)
      : options_(options),
        order_(OrderOptionsOf(job)),
        motion_(MotionOptionsOf(job)),
        axes_(AxesFromGlassOf(job)),
        progress_(progress) {
    order_.executor = executor;
  }

  /// Estimates points that are made in the same channels.
  Result<double> TicksOf(const PointList& points_mm) const {
    if (points_mm.size() < 2) return 0.0;
    const bool sweeps = order_.method == sort::Method::kSweep;
    const auto samples = sort::LocalSamples(
        points_mm, options_.sample_count,
        options_.sample_points * (sweeps ? kSweepSampleRatio : 1), sweeps);
    double ticks = 0, steps = 0;
    for (const auto& sample : samples) {
      PointList part_mm;
      part_mm.reserve(sample.size());
      for (const std::uint32_t index : sample) part_mm.push_back(points_mm[index]);
      const auto at = INTAGLIO_TRY(PlannedTicksOf(part_mm));
      const auto own_steps = static_cast<double>(at.size() - 1);
      ticks += samples.size() == 1 ? at.back() : own_steps * SteadyTicksPerStep(at);
      steps += own_steps;
    }
    return ticks / steps * static_cast<double>(points_mm.size() - 1);
  }

 private:
  /// Of each point, from the start.
  Result<std::vector<std::uint32_t>> PlannedTicksOf(const PointList& part_mm) const {
    const auto order = INTAGLIO_TRY(sort::MakeOrder(
        part_mm, order_,
        [this](std::uint64_t, std::uint64_t) { return !progress_ || progress_(0, 0); }));
    PointList path_mm;
    path_mm.reserve(order.size());
    for (const std::uint32_t index : order) path_mm.push_back(part_mm[index]);
    const auto places = INTAGLIO_TRY(
        machine::AxesAlong(axes_, std::move(path_mm), motion_.limits.travel_mm));
    std::uint64_t subticks = 0;
    std::vector<std::uint32_t> point_ticks;
    motion::PointPlan plan(
        motion_, places.front(), [&](std::span<const motion::Segment> segments) {
          for (const motion::Segment& segment : segments) {
            subticks += segment.duration_subticks;
            if (segment.point < 0) continue;
            point_ticks.push_back(
                static_cast<std::uint32_t>(subticks / motion::kSubticksPerTick));
          }
        });
    for (const Vec3& place : places) plan.Append(place);
    plan.Rest();
    return point_ticks;
  }

  const EstimateOptions& options_;
  sort::OrderOptions order_;
  motion::PlanOptions motion_;
  machine::AxesFromGlass axes_;
  const ProgressSink& progress_;
};

}  // namespace

Result<std::uint64_t> FirstEstimateTicks(const FrozenJob& job, const PointList& points_mm,
                                         std::span<const ChannelMask> masks,
                                         const Executor& executor,
                                         const ProgressSink& progress,
                                         const EstimateOptions& options) {
  Require(masks.size() == points_mm.size(), "{} points have {} masks", points_mm.size(),
          masks.size());
  const Estimator estimator(job, executor, progress, options);
  double ticks = 0;
  for (const ChannelMask mask : DistinctMasks(masks)) {
    PointList of_mask_mm;
    for (std::size_t i = 0; i < points_mm.size(); ++i) {
      if (masks[i] == mask) of_mask_mm.push_back(points_mm[i]);
    }
    ticks += INTAGLIO_TRY(estimator.TicksOf(of_mask_mm));
  }
  return static_cast<std::uint64_t>(std::llround(ticks));
}

}  // namespace intaglio
