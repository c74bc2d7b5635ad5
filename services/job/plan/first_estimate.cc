#include "services/job/plan/first_estimate.h"

#include <cmath>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/sort/local_samples.h"
#include "services/job/plan/point_ticks.h"
#include "services/job/plan/steady_ticks.h"

namespace intaglio {
namespace {

std::size_t SamplePoints(const FrozenJob& job, const EstimateOptions& options) {
  const bool sweeps = job.job().ordering().has_sweep();
  return options.sample_points * (sweeps ? kSweepSampleRatio : 1);
}

/// Estimates points that are made in the same channels.
Result<double> TicksOfMask(const FrozenJob& job, const PointList& points_mm,
                           const Executor& executor, const ProgressSink& progress,
                           const EstimateOptions& options) {
  if (points_mm.size() < 2) return 0.0;
  const auto samples =
      sort::LocalSamples(points_mm, options.sample_count, SamplePoints(job, options),
                         job.job().ordering().has_sweep());
  const ProgressSink go_on = [&](std::uint64_t, std::uint64_t) {
    return !progress || progress(0, 0);
  };
  double ticks = 0, steps = 0;
  for (const auto& sample : samples) {
    PointList part_mm;
    part_mm.reserve(sample.size());
    for (const std::uint32_t index : sample) part_mm.push_back(points_mm[index]);
    const std::vector<ChannelMask> masks(part_mm.size(), 1);
    const auto at = INTAGLIO_TRY(PointTicks(job, part_mm, masks, executor, go_on));
    const auto own_steps = static_cast<double>(at.size() - 1);
    ticks += samples.size() == 1 ? at.back() : own_steps * SteadyTicksPerStep(at);
    steps += own_steps;
  }
  return ticks / steps * static_cast<double>(points_mm.size() - 1);
}

}  // namespace

bool EstimatesWhole(const FrozenJob& job, std::size_t point_count,
                    const EstimateOptions& options) {
  return point_count <= options.sample_count * SamplePoints(job, options) &&
         !job.job().ordering().anneal().has_time_s();
}

Result<std::uint64_t> FirstEstimateTicks(const FrozenJob& job, const PointList& points_mm,
                                         std::span<const ChannelMask> masks,
                                         const Executor& executor,
                                         const ProgressSink& progress,
                                         const EstimateOptions& options) {
  Require(masks.size() == points_mm.size(), "{} points have {} masks", points_mm.size(),
          masks.size());
  double ticks = 0;
  for (const ChannelMask mask : DistinctMasks(masks)) {
    PointList of_mask_mm;
    for (std::size_t i = 0; i < points_mm.size(); ++i) {
      if (masks[i] == mask) of_mask_mm.push_back(points_mm[i]);
    }
    ticks += INTAGLIO_TRY(TicksOfMask(job, of_mask_mm, executor, progress, options));
  }
  return static_cast<std::uint64_t>(std::llround(ticks));
}

}  // namespace intaglio
