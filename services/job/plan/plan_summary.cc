#include "services/job/plan/plan_summary.h"

#include <fmt/format.h>

#include <span>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/crc32.h"
#include "engrave/motion/point_plan.h"
#include "services/job/plan/predicted_errors.h"

namespace intaglio {
namespace {

constexpr std::size_t kProgressPoints = 256;

template <typename T>
void Mix(std::uint32_t& crc, const T& value) {
  crc = io::Crc32(std::as_bytes(std::span(&value, 1)), crc);
}

}  // namespace

Result<PlanSummary> Summarize(const PlanInput& plan, const ProgressSink& progress) {
  const PointList& points_mm = plan.machine_points_mm;
  std::uint32_t crc = 0;
  std::uint64_t subticks = 0, subticks_of_last_point = 0;
  std::vector<std::uint32_t> point_ticks;
  point_ticks.reserve(points_mm.size());
  const auto add = [&](const motion::Segment& segment) {
    if (plan.follow) plan.follow(segment);
    for (int axis = 0; axis < 3; ++axis) {
      Mix(crc, segment.end_position_mm[axis]);
      Mix(crc, segment.end_velocity_mm_s[axis]);
    }
    Mix(crc, segment.duration_subticks);
    subticks += segment.duration_subticks;
    if (segment.point < 0) return;
    subticks_of_last_point = subticks;
    point_ticks.push_back(
        static_cast<std::uint32_t>(subticks / motion::kSubticksPerTick));
  };
  motion::PointPlan planned(plan.options, points_mm.front(),
                            [&add](std::span<const motion::Segment> segments) {
                              for (const motion::Segment& segment : segments)
                                add(segment);
                            });
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    if (i % kProgressPoints == 0 && !progress(i, points_mm.size())) {
      return Fail(ErrorCode::kCancelled, "the plan's summary was cancelled");
    }
    if (i > 0 && !plan.masks.empty() && plan.masks[i] != plan.masks[i - 1])
      planned.Rest();
    planned.Append(points_mm[i]);
  }
  planned.Rest();
  motion::PointMoves moves = planned.moves();
  moves.max_mm *= plan.focus_mm_per_axis_unit;
  moves.square_mm2 *= plan.focus_mm_per_axis_unit * plan.focus_mm_per_axis_unit;
  return PlanSummary{subticks_of_last_point / motion::kSubticksPerTick,
                     fmt::format("{:08x}", crc), moves, std::move(point_ticks)};
}

Result<PlanSummary> Summarize(const FrozenJob& job, PlanInput plan,
                              const ProgressSink& progress) {
  PredictedErrors errors(job, plan.machine_points_mm);
  plan.follow = [&](const motion::Segment& commanded) {
    errors.AppendCommand(commanded);
  };
  auto summary = INTAGLIO_TRY(Summarize(plan, progress));
  if (errors.predicts()) {
    summary.predicted = PredictedSummary{errors.rms_um(), errors.max_um(),
                                         errors.wrong_mechanics_max_um()};
  }
  return summary;
}

}  // namespace intaglio
