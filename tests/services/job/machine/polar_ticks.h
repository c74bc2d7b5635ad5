#pragma once

// A job on the machine with an arm and a rotary table, and the ticks of its points in a
// given order, planned with the limits of the axes.

#include "engrave/sort/order.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/options.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/plan/plan_summary.h"
#include "tests/services/job/test_job.h"

namespace intaglio::polar_ticks {

inline FrozenJob PolarJob() {
  FrozenJob frozen;
  *frozen.mutable_machine() =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto").value();
  JobSpec job = GoodJob();
  job.mutable_laser()->Clear();
  job.mutable_ordering()->mutable_anneal();
  *frozen.mutable_job() = WithDefaults(job, frozen.machine());
  frozen.mutable_optics()->set_stage_per_glass_ratio(0.65);
  // NA 0.2 in glass of index 1.52.
  frozen.mutable_optics()->set_cone_tangent(0.1327);
  return frozen;
}

inline std::uint64_t TicksOf(const FrozenJob& job, PointList axes) {
  PlanInput plan;
  plan.machine_points_mm = std::move(axes);
  plan.options = MotionOptionsOf(job);
  return Summarize(plan, [](std::uint64_t, std::uint64_t) { return true; }).value().ticks;
}

inline PointList AxesOf(const FrozenJob& job, const PointList& points_mm) {
  return machine::AxesAlong(AxesFromGlassOf(job), points_mm,
                            AxisLimitsOf(job.machine()).travel_mm)
      .value();
}

template <typename Index>
PointList InOrder(const PointList& points, const std::vector<Index>& order) {
  PointList ordered;
  for (const Index i : order) ordered.push_back(points[i]);
  return ordered;
}

/// In the order that the job has made of them.
inline PointList JobsOwn(const FrozenJob& job, const PointList& points_mm) {
  return InOrder(points_mm, sort::MakeOrder(points_mm, OrderOptionsOf(job)).value());
}

}  // namespace intaglio::polar_ticks
