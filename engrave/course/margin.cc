#include "engrave/course/margin.h"

#include <algorithm>
#include <span>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

namespace intaglio::course {
namespace {

/// A trial aims at this share of what the last one suggests.
constexpr double kErrorAim = 0.98;
/// Below it another corner speed does not help.
constexpr double kMinPlannedRatio = 0.2;
/// Further on both sides of a part, where the nearest places of its nodes may be on a
/// machine that differs.
constexpr std::size_t kBesideInstants = 256;

struct Margins {
  const Path& path;
  const CoursePlan& plan;
  const Tracking& tracking;
  const std::vector<AxisPair>& machines;
  const Instants& instants;
  const SearchWindow& window;
};

/// For each machine.
std::vector<double> WorstOfPart(const Margins& of, const Part& part) {
  const AxisPair& axes = of.tracking.axes();
  const double period_s = of.tracking.options().period_s;
  std::size_t memory = MemoryInstants(axes, period_s);
  for (const AxisPair& machine : of.machines)
    memory = std::max(memory, MemoryInstants(machine, period_s));
  const std::size_t measured = part.begin - std::min(part.begin, kBesideInstants);
  const std::size_t begin = measured - std::min(measured, memory);
  const std::size_t end = std::min(part.end + kBesideInstants, of.instants.count);
  const Tracked tracked =
      of.tracking.SetpointsOf(of.path, of.plan.law, of.instants, {begin, end});
  const auto run = [&](const AxisPair& machine) {
    std::vector<Vec2> course = RunAxes(machine, period_s, tracked.setpoints_mm);
    course.erase(course.begin(),
                 course.begin() + static_cast<std::ptrdiff_t>(measured - begin));
    return course;
  };
  const std::vector<Vec2> planned_mm = run(axes);
  const NeighbourError beside(of.path, planned_mm,
                              std::span(tracked.commanded_s_mm).subspan(measured - begin),
                              of.window);
  std::vector<double> worst_mm;
  for (const AxisPair& machine : of.machines) {
    worst_mm.push_back(
        beside.WorstOf(run(machine), part.begin - measured, part.end - measured));
  }
  return worst_mm;
}

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
                   double tolerance_mm, const ModelError& error,
                   const Executor& executor) {
  const Tracking tracking(axes, plan.tracking);
  const SearchWindow window = tracking.WindowFor(path.greatest_feed_mm_s(), tolerance_mm);
  Margin margin;
  std::vector<AxisPair> machines;
  for (const MechanicsFactors& factors : WrongMechanics(error)) {
    margin.cases.push_back({factors, 0});
    machines.push_back({axes[0].WithMechanics(factors.frequency[0], factors.damping[0]),
                        axes[1].WithMechanics(factors.frequency[1], factors.damping[1])});
  }
  // Until the slowest of them has settled.
  Instants instants = tracking.InstantsOf(plan.law, axes, Exactness::kAxes);
  for (const AxisPair& machine : machines) {
    const Instants own = tracking.InstantsOf(plan.law, machine, Exactness::kAxes);
    instants.count = std::max(instants.count, own.count);
  }
  const std::vector<Part> parts = PartsOf(instants);
  std::vector<std::vector<double>> worst_mm(parts.size());
  RunEach(executor, parts.size(), [&](std::size_t i) {
    worst_mm[i] =
        WorstOfPart({path, plan, tracking, machines, instants, window}, parts[i]);
  });
  for (std::size_t k = 0; k < machines.size(); ++k)
    for (const std::vector<double>& part : worst_mm)
      margin.cases[k].worst_mm = std::max(margin.cases[k].worst_mm, part[k]);
  margin.worst = *std::ranges::max_element(margin.cases, {}, &MarginCase::worst_mm);
  margin.holds = margin.worst.worst_mm <= tolerance_mm;
  return margin;
}

namespace {

Result<PlanWithMargin> PlanByTrials(const Path& path, const AxisPair& axes,
                                    const PlanOptions& options, const ModelError& error) {
  PlanWithMargin found;
  PlanOptions trial = options;
  for (int i = 0; i < kMarginTrials; ++i) {
    found.plan = INTAGLIO_TRY(PlanCourse(path, axes, trial));
    found.margin = CheckMargin(path, found.plan, axes, options.tolerance_mm, error,
                               options.executor);
    found.planned_ratio = trial.planned_ratio;
    if (found.margin.holds || !found.plan.holds) return found;
    trial.planned_ratio *=
        kErrorAim * std::min(1.0, options.tolerance_mm / found.margin.worst.worst_mm);
    if (trial.planned_ratio < kMinPlannedRatio) return found;
  }
  return found;
}

}  // namespace

Result<PlanWithMargin> PlanWithin(const Path& path, const AxisPair& axes,
                                  const PlanOptions& options, const ModelError& error) {
  auto found = INTAGLIO_TRY(PlanByTrials(path, axes, options, error));
  if (!options.compensate || !options.swing) return found;
  if (!found.plan.law.swings && found.margin.holds) return found;
  // A swing may need more of a reserve than it saves.
  PlanOptions plain = options;
  plain.swing = false;
  auto other = INTAGLIO_TRY(PlanByTrials(path, axes, plain, error));
  const auto holds = [](const PlanWithMargin& of) {
    return of.plan.holds && of.margin.holds;
  };
  const bool faster = other.plan.law.duration_s < found.plan.law.duration_s;
  return holds(other) && (!holds(found) || faster) ? other : found;
}

}  // namespace intaglio::course
