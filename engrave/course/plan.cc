#include "engrave/course/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/try.h"
#include "engrave/course/correction.h"
#include "engrave/course/kernel_figures.h"
#include "engrave/course/swing_table.h"

namespace intaglio::course {
namespace {

struct Range {
  const char* name;
  double value, min, max;
};

Status CheckRanges(std::initializer_list<Range> ranges) {
  for (const Range& range : ranges) {
    if (range.value >= range.min && range.value <= range.max) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} {} is outside {}..{}", range.name, range.value, range.min,
                            range.max),
                fmt::format("{}", range.value));
  }
  return {};
}

}  // namespace

Status CheckOptions(const PlanOptions& options) {
  INTAGLIO_TRY(CheckRanges({{"tolerance_mm", options.tolerance_mm, 1e-4, 10},
                            {"acceleration_mm_s2", options.acceleration_mm_s2, 1, 1e6},
                            {"jerk_mm_s3", options.jerk_mm_s3.value_or(1e6), 1, 1e12},
                            {"motor_mm_s2", options.motor_mm_s2.value_or(1), 1, 1e9},
                            {"kernel_s", options.kernel_s.value_or(1e-3), 1e-5, 10},
                            {"period_s", options.period_s, 1e-5, 0.1},
                            {"planned_ratio", options.planned_ratio, 0.05, 1},
                            {"rounds", static_cast<double>(options.rounds), 1, 100}}));
  if (options.compensate && !options.motor_mm_s2) {
    return Fail(ErrorCode::kMissing,
                "motor_mm_s2 is missing: a compensated course is limited by the "
                "acceleration of its motors; give that of the weaker axis");
  }
  return {};
}

Allowed AllowedBy(const PlanOptions& options) {
  Allowed allowed;
  allowed.error_mm = options.tolerance_mm * options.planned_ratio;
  allowed.motor_mm_s2 = options.motor_mm_s2.value_or(0);
  if (options.compensate) allowed.jerk_mm_s3 = options.jerk_mm_s3.value_or(0);
  return allowed;
}

namespace {

/// Kernels to choose from, in units of KernelTime.
constexpr double kKernelLengths[] = {1.6, 2.1, 2.7, 3.3, 3.9, 4.8, 6, 8, 11};
/// Shares of what the motor's limit allows on a straight line.
constexpr double kAccelerationShares[] = {0.4, 0.55, 0.7, 0.85};

/// 1 / w of the slowest mechanics; of stiff ones what rounding by the tolerance takes
/// with the motors' acceleration, v T ~ tolerance and v / T ~ acceleration.
double KernelTime(const AxisPair& axes, const Allowed& allowed) {
  double time_s = 1.5 * std::sqrt(allowed.error_mm / allowed.motor_mm_s2);
  for (const AxisDynamics& axis : axes)
    time_s = std::max(time_s, 1 / axis.parameters().natural_rad_s);
  return time_s;
}

/// A course with swings: its kernel in units of KernelTime, and the longest swing on one
/// side in lengths of the kernel.
struct SwungTrial {
  double kernel, half;
};
constexpr SwungTrial kSwungTrials[] = {{4, 0.75}, {6, 0.75}, {6, 1.2}, {6, 2.2}};
constexpr double kSwungAccelerationShare = 0.85;
/// How often corners that do not keep the limits lose their swings.
constexpr int kDroppings = 3;
constexpr std::size_t kChoosingSegments = 1000;
/// Longer contours are planned without swings, to keep their time of planning.
constexpr std::size_t kMaxSwungSegments = 20'000;

struct Choice {
  TrackingOptions tracking;
  double acceleration_mm_s2 = 0;
  double longest_swing = 0;  ///< on one side, in lengths of the kernel
};

Choice DirectChoice(const PlanOptions& options) {
  TrackingOptions tracking;
  tracking.period_s = options.period_s;
  if (options.jerk_mm_s3)
    tracking.smooth_s = 2 * options.acceleration_mm_s2 / *options.jerk_mm_s3;
  return {tracking, options.acceleration_mm_s2};
}

/// The acceleration along a straight line by which a change from it to its opposite, a
/// step of twice its size, keeps motor and jerk.
double Reach(const KernelFigures& figures, const PlanOptions& options) {
  double reach_mm_s2 =
      *options.motor_mm_s2 / (2 * std::max(figures.motor_per_acceleration[0],
                                           figures.motor_per_acceleration[1]) -
                              1);
  if (options.jerk_mm_s3)
    reach_mm_s2 =
        std::min(reach_mm_s2, *options.jerk_mm_s3 / (2 * figures.jerk_per_acceleration));
  return reach_mm_s2;
}

/// The kernel and the acceleration whose first guess of all corners takes the shortest
/// time.
Choice CompensatedChoice(const Path& path, const AxisPair& axes,
                         const PlanOptions& options) {
  const Allowed allowed = AllowedBy(options);
  std::vector<double> lengths_s;
  for (const double length : kKernelLengths)
    lengths_s.push_back(length * KernelTime(axes, allowed));
  if (options.kernel_s) lengths_s = {*options.kernel_s};
  Choice best;
  double shortest_s = std::numeric_limits<double>::infinity();
  for (const double length_s : lengths_s) {
    const Tracking tracking(axes, {options.period_s, 0, length_s});
    const KernelFigures figures = FiguresOf(tracking.kernel(), axes);
    const double reach_mm_s2 = Reach(figures, options);
    for (const double share : kAccelerationShares) {
      const double a = std::min(options.acceleration_mm_s2, share * reach_mm_s2);
      const Speeds speeds = FirstSpeeds(path, tracking, allowed, a);
      const double time_s = PlanSpeeds(path, {speeds.node_mm_s, speeds.segment_mm_s,
                                              speeds.acceleration_mm_s2})
                                .duration_s +
                            tracking.kernel().length_s();
      if (time_s >= shortest_s) continue;
      shortest_s = time_s;
      best = {tracking.options(), a};
    }
  }
  return best;
}

std::string ReasonOf(const Path& path, const Evaluation& evaluation) {
  const auto worst =
      std::max_element(evaluation.load_ratio.begin(), evaluation.load_ratio.end());
  const auto node = static_cast<std::size_t>(worst - evaluation.load_ratio.begin());
  const Vec2& at = path.node_mm(node);
  return fmt::format(
      "at node {} ({:.3f}, {:.3f} mm) error, motor or jerk is {:.2f} times what is "
      "allowed, also when it is passed slowly; compensate the axes, or lower the "
      "acceleration",
      node, at.x(), at.y(), *worst);
}

CoursePlan PlanOf(const Path& path, const Choice& choice, const Corrected& corrected) {
  CoursePlan plan;
  plan.law = corrected.law;
  plan.tracking = choice.tracking;
  plan.acceleration_mm_s2 = choice.acceleration_mm_s2;
  plan.nodes = corrected.evaluation.nodes;
  for (const NodeFigures& node : plan.nodes) {
    plan.worst_one_sided_mm = std::max(plan.worst_one_sided_mm, node.one_sided_mm);
    plan.worst_node_miss_mm = std::max(plan.worst_node_miss_mm, node.node_miss_mm);
  }
  plan.motor_mm_s2 = corrected.evaluation.motor_mm_s2;
  plan.jerk_mm_s3 = corrected.evaluation.jerk_mm_s3;
  plan.holds = corrected.holds;
  if (!plan.holds) plan.reason = ReasonOf(path, corrected.evaluation);
  return plan;
}

Corrected CorrectBy(const Path& path, const AxisPair& axes, const PlanOptions& options,
                    const Choice& choice) {
  const Allowed allowed = AllowedBy(options);
  const Tracking tracking(axes, choice.tracking);
  return CorrectSpeeds(path, tracking, allowed,
                       FirstSpeeds(path, tracking, allowed, choice.acceleration_mm_s2),
                       options.rounds, {}, options.executor);
}

/// Corners that do not keep the limits lose their swings, and so do their neighbours.
Corrected CorrectSwung(const Path& path, const AxisPair& axes, const PlanOptions& options,
                       const Choice& choice, SwingTable& table) {
  const Allowed allowed = AllowedBy(options);
  const Tracking tracking(axes, choice.tracking);
  const Speeds plain = FirstSpeeds(path, tracking, allowed, choice.acceleration_mm_s2);
  Speeds speeds = plain;
  // A reserve lowers the speeds of the same swings.
  Allowed full = allowed;
  full.error_mm = options.tolerance_mm;
  table.AddTo(path, tracking, full, {choice.acceleration_mm_s2, choice.longest_swing},
              speeds);
  Corrected corrected;
  for (int i = 0; i < kDroppings; ++i) {
    corrected = CorrectSpeeds(path, tracking, allowed, speeds, options.rounds, {},
                              options.executor);
    if (corrected.holds) break;
    auto fewer = std::make_shared<Swings>(*speeds.swings);
    const std::vector<double>& load_ratio = corrected.evaluation.load_ratio;
    for (std::size_t node = 0; node < path.node_count(); ++node) {
      if (load_ratio[node] <= 1) continue;
      const std::size_t last = std::min(node + 1, path.node_count() - 1);
      for (std::size_t k = node == 0 ? 0 : node - 1; k <= last; ++k) {
        fewer->of_node[k].shape = -1;
        speeds.node_mm_s[k] = plain.node_mm_s[k];
      }
    }
    speeds.swings = std::move(fewer);
  }
  return corrected;
}

Choice SwungChoice(const AxisPair& axes, const PlanOptions& options,
                   const SwungTrial& trial) {
  const double length_s =
      options.kernel_s.value_or(trial.kernel * KernelTime(axes, AllowedBy(options)));
  const Tracking tracking(axes, {options.period_s, 0, length_s});
  const double reach_mm_s2 = Reach(FiguresOf(tracking.kernel(), axes), options);
  return {tracking.options(),
          std::min(options.acceleration_mm_s2, kSwungAccelerationShare * reach_mm_s2),
          trial.half};
}

CoursePlan PlainPlan(const Path& path, const AxisPair& axes, const PlanOptions& options) {
  const Choice choice = CompensatedChoice(path, axes, options);
  return PlanOf(path, choice, CorrectBy(path, axes, options, choice));
}

CoursePlan SwungPlan(const Path& path, const AxisPair& axes, const PlanOptions& options,
                     const Choice& choice, SwingTable& table) {
  return PlanOf(path, choice, CorrectSwung(path, axes, options, choice, table));
}

double TotalS(const CoursePlan& plan) {
  return plan.law.duration_s + plan.tracking.kernel_s.value_or(0);
}

struct Fastest {
  CoursePlan plan;
  std::optional<Choice> swung;  ///< when the plan has swings
};

/// The plan without swings, or one with them that takes less time and holds.
Fastest FastestOf(const Path& path, const AxisPair& axes, const PlanOptions& options,
                  SwingTable& table) {
  Fastest best{PlainPlan(path, axes, options), std::nullopt};
  for (const SwungTrial& trial : kSwungTrials) {
    const Choice choice = SwungChoice(axes, options, trial);
    CoursePlan plan = SwungPlan(path, axes, options, choice, table);
    if (plan.holds && (!best.plan.holds || TotalS(plan) < TotalS(best.plan)))
      best = {std::move(plan), choice};
  }
  return best;
}

CoursePlan CompensatedPlan(const Path& path, const AxisPair& axes,
                           const PlanOptions& options) {
  if (!options.swing || path.segment_count() > kMaxSwungSegments)
    return PlainPlan(path, axes, options);
  std::shared_ptr<SwingTable> table = options.swings;
  if (!table) table = std::make_shared<SwingTable>();
  if (path.segment_count() <= kChoosingSegments)
    return FastestOf(path, axes, options, *table).plan;
  // The begin of a long contour chooses for the rest.
  const Fastest begin = FastestOf(path.Part(0, kChoosingSegments), axes, options, *table);
  if (begin.swung) {
    CoursePlan plan = SwungPlan(path, axes, options, *begin.swung, *table);
    if (plan.holds) return plan;
  }
  return PlainPlan(path, axes, options);
}

}  // namespace

Result<CoursePlan> PlanCourse(const Path& path, const AxisPair& axes,
                              const PlanOptions& options) {
  INTAGLIO_TRY(CheckOptions(options));
  if (options.compensate) return CompensatedPlan(path, axes, options);
  const Choice choice = DirectChoice(options);
  Corrected corrected = CorrectBy(path, axes, options, choice);
  // The rounds compute no motor that has no limit.
  const Tracking tracking(axes, choice.tracking);
  corrected.evaluation = Evaluate(path, corrected.law, tracking, AllowedBy(options),
                                  Exactness::kAxes, options.executor);
  return PlanOf(path, choice, corrected);
}

Tracked FollowPlan(const Path& path, const CoursePlan& plan, const AxisPair& axes,
                   const AxisPair& real) {
  return Tracking(axes, plan.tracking)
      .Follow(path, plan.law, real, Exactness::kAxes, true);
}

CoursePlan EvaluateLaw(const Path& path, const AxisPair& axes, const SpeedLaw& law,
                       const PlanOptions& options) {
  const Choice choice = DirectChoice(options);
  const Tracking tracking(axes, choice.tracking);
  Corrected corrected;
  corrected.law = law;
  corrected.evaluation =
      Evaluate(path, law, tracking, AllowedBy(options), Exactness::kAxes);
  corrected.holds = corrected.evaluation.worst_load_ratio <= 1;
  return PlanOf(path, choice, corrected);
}

}  // namespace intaglio::course
