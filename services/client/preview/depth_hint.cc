#include "services/client/preview/depth_hint.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/try.h"
#include "services/client/figure_text.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/machine/focus_offset.h"

namespace intaglio::client {
namespace {

// Below it points wait for z, or their mirrors are slower than the laser.
constexpr double kIdleUtilisation = 0.9;
constexpr double kWiderRatio = 1.0 / 3;
constexpr double kWorthSaving = 0.9;

/// The same job with another tolerance; nullopt: it has a slab of its own.
std::optional<FrozenJob> WithTolerance(const FrozenJob& job, double tolerance_um) {
  const auto slab_mm = [](const FrozenJob& one) {
    return one.job().ordering().sweep().slab_mm();
  };
  const auto with_usual_slab = [](FrozenJob one) {
    one.mutable_job()->mutable_ordering()->mutable_sweep()->clear_slab_mm();
    *one.mutable_job() = WithDefaults(one.job(), one.machine());
    return one;
  };
  if (slab_mm(with_usual_slab(job)) != slab_mm(job)) return std::nullopt;
  FrozenJob wider = job;
  wider.mutable_job()->mutable_motion()->set_depth_tolerance_um(tolerance_um);
  return with_usual_slab(std::move(wider));
}

}  // namespace

Result<std::optional<Warning>> SlowDepthAxisIn(const FrozenJob& job,
                                               const TimePreview& time,
                                               const CloudToTime& cloud,
                                               std::size_t max_planned_points,
                                               const Executor& executor,
                                               const ProgressSink& progress) {
  const std::optional<Warning> none;
  const JobSpec& spec = job.job();
  if (!spec.ordering().has_sweep() || time.utilisation() >= kIdleUtilisation) return none;
  const MachineLens* lens = FindLens(job.machine(), spec.lens().focal_length_mm());
  if (lens == nullptr) return none;
  const double wider_um = std::round(1e3 * kWiderRatio * lens->crack_length_mm());
  const double tolerance_um = spec.motion().depth_tolerance_um();
  if (wider_um <= tolerance_um) return none;
  const auto wider = WithTolerance(job, wider_um);
  if (!wider) return none;
  const TimePreview faster =
      INTAGLIO_TRY(EstimateTime(*wider, cloud, max_planned_points, executor, progress));
  if (faster.machining_time_s() > kWorthSaving * time.machining_time_s()) return none;
  return std::optional(MakeWarning(
      WarningCode::kSlowDepthAxis,
      fmt::format("z is slow for points within {:g} um of their depth: {:.2f} points a "
                  "tick; --set motion.depth_tolerance_um={:g}, a third of a crack's "
                  "length, gives {:.2f}, about {} in place of {}",
                  tolerance_um, time.utilisation(), wider_um, faster.utilisation(),
                  ShortDuration(faster.machining_time_s()),
                  ShortDuration(time.machining_time_s()))));
}

}  // namespace intaglio::client
