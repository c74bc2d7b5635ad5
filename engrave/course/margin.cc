#include "engrave/course/margin.h"

#include <algorithm>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

namespace intaglio::course {
namespace {

/// A trial aims at this share of what the last one suggests.
constexpr double kErrorAim = 0.98;
/// Below it another corner speed does not help.
constexpr double kMinPlannedRatio = 0.2;

}  // namespace

std::vector<MechanicsFactors> WrongMechanics(const ModelError& error) {
  Require(error.frequency >= 0 && error.frequency <= 0.5 && error.damping >= 0 &&
              error.damping <= 0.5,
          "model error {} and {} is outside 0..0.5", error.frequency, error.damping);
  std::vector<MechanicsFactors> machines;
  for (const double sign : {-1.0, 1.0}) {
    for (const int which : {0, 1, 2}) {  // x, y, both
      MechanicsFactors frequency, damping;
      for (int axis = 0; axis < 2; ++axis) {
        if (which != 2 && which != axis) continue;
        const auto i = static_cast<std::size_t>(axis);
        frequency.frequency[i] += sign * error.frequency;
        damping.damping[i] += sign * error.damping;
      }
      machines.push_back(frequency);
      machines.push_back(damping);
    }
  }
  return machines;
}

Margin CheckMargin(const Path& path, const CoursePlan& plan, const AxisPair& axes,
                   double tolerance_mm, const ModelError& error) {
  double feed_mm_s = 0;
  for (const Segment& segment : path.segments())
    feed_mm_s = std::max(feed_mm_s, segment.feed_mm_s);
  const Tracking tracking(axes, plan.tracking);
  const SearchWindow window = tracking.WindowFor(feed_mm_s, tolerance_mm);
  Margin margin;
  for (const MechanicsFactors& factors : WrongMechanics(error)) {
    const AxisPair real{axes[0].WithMechanics(factors.frequency[0], factors.damping[0]),
                        axes[1].WithMechanics(factors.frequency[1], factors.damping[1])};
    const Tracked tracked =
        tracking.Follow(path, plan.law, real, Exactness::kAxes, false);
    const ContourError found =
        MeasureContour(path, tracked.actual_mm, tracked.commanded_s_mm, window);
    margin.cases.push_back({factors, found.worst_mm()});
  }
  margin.worst = *std::ranges::max_element(margin.cases, {}, &MarginCase::worst_mm);
  margin.holds = margin.worst.worst_mm <= tolerance_mm;
  return margin;
}

Result<PlanWithMargin> PlanWithin(const Path& path, const AxisPair& axes,
                                  const PlanOptions& options, const ModelError& error) {
  PlanWithMargin found;
  PlanOptions trial = options;
  for (int i = 0; i < kMarginTrials; ++i) {
    found.plan = INTAGLIO_TRY(PlanCourse(path, axes, trial));
    found.margin = CheckMargin(path, found.plan, axes, options.tolerance_mm, error);
    found.planned_ratio = trial.planned_ratio;
    if (found.margin.holds || !found.plan.holds) return found;
    trial.planned_ratio *=
        kErrorAim * std::min(1.0, options.tolerance_mm / found.margin.worst.worst_mm);
    if (trial.planned_ratio < kMinPlannedRatio) return found;
  }
  return found;
}

}  // namespace intaglio::course
