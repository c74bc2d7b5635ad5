#include "engrave/course/margin.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/engrave/course/cut_program.h"
#include "tests/engrave/course/oracle.h"

namespace intaglio::course {
namespace {

TEST(WrongMechanics, AreTwelveMachinesAroundTheModel) {
  const auto machines = WrongMechanics({0.05, 0.2});
  ASSERT_EQ(machines.size(), 12U);
  for (const MechanicsFactors& m : machines) {
    const bool other_frequency = m.frequency[0] != 1 || m.frequency[1] != 1;
    const bool other_damping = m.damping[0] != 1 || m.damping[1] != 1;
    EXPECT_NE(other_frequency, other_damping);
  }
}

// The plan holds its tolerance on the machines it promises, by the independent model.
TEST(PlanWithin, HoldsOnMachinesThatDiffer) {
  for (const Path& path : CutProgram(1, 100, 81)) {
    const PlanWithMargin found =
        PlanWithin(path, MeasuredMachine(), CompensatedOptions(), {0.05, 0.2}).value();
    ASSERT_TRUE(found.margin.holds) << found.margin.worst.worst_mm;
    const AxisPair machine = MeasuredMachine();
    for (const MarginCase& c : found.margin.cases) {
      const AxisPair real{
          machine[0].WithMechanics(c.factors.frequency[0], c.factors.damping[0]),
          machine[1].WithMechanics(c.factors.frequency[1], c.factors.damping[1])};
      const Tracked tracked = FollowPlan(path, found.plan, MeasuredMachine(), real);
      const auto actual = OracleFollow(OracleOf(real), tracked.setpoints_mm,
                                       found.plan.tracking.period_s, 1);
      const OracleError error = OracleMeasure(path, actual, tracked.commanded_s_mm);
      // Runge-Kutta in steps of .1 ms.
      EXPECT_LE(error.one_sided_mm, 0.1 + 1e-4);
      EXPECT_LE(error.node_miss_mm, 0.1 + 1e-4);
    }
  }
}

// A contour of several parts, of which each is followed by itself: the same errors as of
// the whole, which is measured place by place, whatever does the work.
TEST(CheckMargin, FindsInPartsWhatTheWholeHas) {
  std::vector<Vec2> nodes_mm{{0, 0}};
  for (int i = 1; i < 300; ++i)
    nodes_mm.push_back(nodes_mm.back() + 5 * Vec2(std::cos(1.1 * i * i), std::sin(i)));
  const Path path = PolylinePath(nodes_mm, 100);
  const AxisPair machine = MeasuredMachine();
  for (const PlanOptions& options : {PlanOptions{}, CompensatedOptions()}) {
    CoursePlan plan;
    plan.tracking.period_s = 0.0005;
    if (options.compensate) plan.tracking.kernel_s = 0.022;
    plan.law = PlanSpeeds(path, std::vector<double>(path.node_count() - 2, 25), 5000);
    ASSERT_GT(plan.law.duration_s, 3 * kPartInstants * plan.tracking.period_s);
    const Executor backwards = [](std::size_t count, const auto& work) {
      while (count > 0) work(--count);
    };
    const Margin margin = CheckMargin(path, plan, machine, 0.1, {}, backwards);
    const Tracking tracking(machine, plan.tracking);
    for (const MarginCase& c : margin.cases) {
      const AxisPair real{
          machine[0].WithMechanics(c.factors.frequency[0], c.factors.damping[0]),
          machine[1].WithMechanics(c.factors.frequency[1], c.factors.damping[1])};
      const Tracked whole = FollowPlan(path, plan, machine, real);
      const ContourError error = MeasureContour(
          path, whole.actual_mm, whole.commanded_s_mm, tracking.WindowFor(100, 0.1));
      EXPECT_GT(error.worst_mm(), 0.01);
      EXPECT_NEAR(c.worst_mm, error.worst_mm(), 1e-8);
    }
  }
}

// Without a reserve the same machines cut further than the tolerance, and the margin
// reports it.
TEST(CheckMargin, ReportsThatAPlanWithoutReserveDoesNotHold) {
  int held = 0;
  const auto program = CutProgram(1, 100, 81);
  for (const Path& path : program) {
    const CoursePlan plan =
        PlanCourse(path, MeasuredMachine(), CompensatedOptions()).value();
    const Margin margin = CheckMargin(path, plan, MeasuredMachine(), 0.1, {0.05, 0.2});
    EXPECT_EQ(margin.holds, margin.worst.worst_mm <= 0.1);
    held += margin.holds ? 1 : 0;
    EXPECT_LE(CheckMargin(path, plan, MeasuredMachine(), 0.1, {0, 0}).worst.worst_mm,
              0.1 * 1.001);
  }
  EXPECT_LT(held, static_cast<int>(program.size()));
}

// Mechanics that no identification would leave so wrong.
TEST(PlanWithin, ReportsWhatNoReserveHolds) {
  const Path corner = CornerPath(0.7, 1.5, 20, 100);
  PlanOptions options = CompensatedOptions();
  options.tolerance_mm = 0.01;
  const PlanWithMargin found =
      PlanWithin(corner, MeasuredMachine(), options, {0.5, 0.5}).value();
  EXPECT_FALSE(found.margin.holds);
  EXPECT_GT(found.margin.worst.worst_mm, 0.01);
}

}  // namespace
}  // namespace intaglio::course
